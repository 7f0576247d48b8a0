"""A player's plays are found by the player's mark."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the index."""
    marked = sa.text("who IS NOT NULL")
    op.create_index("drops_who", "drops", ["who"], sqlite_where=marked, postgresql_where=marked)
