"""Add what drops need that are facts, and the history of the ledger: its restores and keys."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns and tables, and count the results that exist.

    Keys of release 1.0 go: two callers may have used the same one, so none may find a fact.
    """
    for name in ("rooms", "drops", "inputs"):
        op.drop_index(f"{name}_key", name)
        op.drop_column(name, "key")
    op.create_table(
        "idempotency_keys",
        sa.Column("scope", sa.String(length=64), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=False),
        sa.Column("request", sa.String(length=64), nullable=False),
        sa.Column("run", sa.BigInteger(), nullable=False),
        sa.Column("fact", sa.String(length=64), nullable=False),
        sa.PrimaryKeyConstraint("scope", "key"),
    )
    op.add_column("rooms", sa.Column("rules", sa.Integer(), nullable=False, server_default="1"))
    op.create_table(
        "tallies",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("bin", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("results", sa.BigInteger(), nullable=False),
        sa.ForeignKeyConstraint(["room"], ["rooms.number"]),
        sa.PrimaryKeyConstraint("room", "bin"),
    )
    op.execute(
        "INSERT INTO tallies (room, bin, results) "
        "SELECT room, COALESCE(bin, -1), COUNT(*) FROM results GROUP BY room, COALESCE(bin, -1)"
    )
    op.add_column("writers", sa.Column("former", sa.String(length=32), nullable=True))
    op.create_table(
        "restores",
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("log", sa.String(length=32), nullable=False),
        sa.Column("superseded", sa.String(length=32), nullable=True),
        sa.Column("statement", sa.Text(), nullable=False),
        sa.Column("signature", sa.String(length=128), nullable=False),
        sa.PrimaryKeyConstraint("number"),
    )
    op.create_table(
        "keys",
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("name", sa.String(length=32), nullable=False),
        sa.Column("value", sa.String(length=64), nullable=False),
        sa.Column("since", sa.Double(), nullable=False),
        sa.Column("statement", sa.Text(), nullable=True),
        sa.Column("signature", sa.String(length=128), nullable=True),
        sa.Column("former_signature", sa.String(length=128), nullable=True),
        sa.PrimaryKeyConstraint("number"),
    )
