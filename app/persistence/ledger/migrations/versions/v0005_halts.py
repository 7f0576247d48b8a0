"""Tables that an operator has halted."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table. Written out here: what `tables` says will go on changing."""
    op.create_table(
        "halts",
        sa.Column("room", sa.String(64), primary_key=True),
        sa.Column("since", sa.Double, nullable=False),
    )
