"""Inputs of rooms whose balls touch each other."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table. Written out here: what `tables` says will go on changing."""
    op.create_table(
        "inputs",
        sa.Column("room", sa.BigInteger, sa.ForeignKey("rooms.number"), primary_key=True),
        sa.Column("number", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("tick", sa.BigInteger, nullable=False),
        sa.Column("data", sa.Text, nullable=False),
        sa.Column("who", sa.String(64)),
    )
