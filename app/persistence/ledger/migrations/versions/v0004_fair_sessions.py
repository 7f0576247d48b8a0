"""Players' sessions, the log of their receipts, and a mark on drops that were practice."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables. Written out here: what `tables` says will go on changing."""
    practice = sa.Column("practice", sa.Boolean, nullable=False, server_default=sa.false())
    op.add_column("drops", practice)
    op.create_table(
        "fair_sessions",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("room", sa.String(64), nullable=False),
        sa.Column("board", sa.String(64), sa.ForeignKey("boards.digest"), nullable=False),
        sa.Column("server_seed", sa.String(64), nullable=False),
        sa.Column("client_seed", sa.String(64)),
        sa.Column("statement", sa.Text, nullable=False),
        sa.Column("signature", sa.String(128), nullable=False),
        sa.Column("opened", sa.Double, nullable=False),
        sa.Column("end", sa.Text),
        sa.Column("end_signature", sa.String(128)),
    )
    op.create_table(
        "receipts",
        sa.Column("leaf", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("session", sa.String(64), sa.ForeignKey("fair_sessions.id"), nullable=False),
        sa.Column("number", sa.BigInteger, nullable=False),
        sa.Column("room", sa.BigInteger, nullable=False),
        sa.Column("ball", sa.BigInteger, nullable=False),
        sa.Column("receipt", sa.Text, nullable=False),
        sa.Column("root", sa.String(64), nullable=False),
        sa.Column("signature", sa.String(128), nullable=False),
        sa.UniqueConstraint("session", "number", name="receipts_number"),
        sa.UniqueConstraint("room", "ball", name="receipts_ball"),
    )
    op.create_table(
        "log_nodes",
        sa.Column("level", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("number", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("hash", sa.String(64), nullable=False),
    )
