"""Add what tables need that are facts: scoped keys, tallies of results, the rules of each run."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns and the table, and count the results that exist.

    Keys of release 1.0 have no scope: two callers may have used the same one, so none finds a drop.
    """
    scoped = sa.text("scope IS NOT NULL")
    for name in ("drops", "inputs"):
        op.add_column(name, sa.Column("scope", sa.String(length=64), nullable=True))
        op.add_column(name, sa.Column("request", sa.String(length=64), nullable=True))
        op.drop_index(f"{name}_key", name)
        op.create_index(
            f"{name}_key",
            name,
            ["room", "scope", "key"],
            unique=True,
            sqlite_where=scoped,
            postgresql_where=scoped,
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
