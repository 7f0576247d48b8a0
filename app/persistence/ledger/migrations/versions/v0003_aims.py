"""The aim of a drop: the middle of what its seed draws, where a player chose it."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; a drop of before was aimed nowhere."""
    op.add_column("drops", sa.Column("aim", sa.Double))
