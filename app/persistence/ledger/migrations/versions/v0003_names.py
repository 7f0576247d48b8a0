"""Drops may carry a name and a colour."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns, which are empty in the drops that there are."""
    op.add_column("drops", sa.Column("name", sa.Text(), nullable=True))
    op.add_column("drops", sa.Column("colour", sa.String(length=7), nullable=True))
