"""Add what tables need that are facts: idempotency keys, tallies of results, rules of each run."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column and the tables, and count the results that exist.

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
