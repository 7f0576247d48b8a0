"""What was staked and paid in all, with what the ledger has of it so far."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table and fill it. Written out here: what `tables` says will go on changing."""
    op.create_table(
        "totals",
        sa.Column("board", sa.String(64), primary_key=True),
        sa.Column("stake", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("aimed", sa.Boolean, primary_key=True),
        sa.Column("plays", sa.BigInteger, nullable=False),
        sa.Column("staked", sa.BigInteger, nullable=False),
        sa.Column("squares", sa.Double, nullable=False),
        sa.Column("paid", sa.BigInteger, nullable=False),
    )
    bands = " ".join(f"WHEN d.stake >= {10**power} THEN {10**power}" for power in range(9, 0, -1))
    op.execute(
        "INSERT INTO totals (board, stake, aimed, plays, staked, squares, paid) "
        f"SELECT r.board, CASE {bands} ELSE 1 END AS band, d.aim IS NOT NULL AS aimed, "
        "COUNT(*), SUM(d.stake), SUM(CAST(d.stake AS DOUBLE PRECISION) * d.stake), SUM(e.payout) "
        "FROM results e JOIN drops d ON d.room = e.room AND d.ball = e.ball "
        "JOIN rooms r ON r.number = d.room WHERE d.stake > 0 AND e.bin IS NOT NULL "
        "GROUP BY r.board, band, aimed"
    )
