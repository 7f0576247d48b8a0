"""Add a name and a colour to drops."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; existing drops have neither."""
    op.add_column("drops", sa.Column("name", sa.Text(), nullable=True))
    op.add_column("drops", sa.Column("colour", sa.String(length=7), nullable=True))
