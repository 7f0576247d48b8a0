"""The tables of release 1.0, from which migrations start; `tables` makes those of a new ledger."""

revision = "0005"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Do nothing: only a ledger that has these tables begins here."""
