"""Add draws, for rooms whose bins are drawn with exact odds."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add a table of draws, and each room's draw; existing rooms have none."""
    op.create_table(
        "draws",
        sa.Column("digest", sa.String(length=64), nullable=False),
        sa.Column("json", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("digest"),
    )
    op.add_column("rooms", sa.Column("draw", sa.String(length=64), nullable=True))
