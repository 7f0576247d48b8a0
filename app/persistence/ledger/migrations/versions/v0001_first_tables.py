"""Boards, rooms, drops, results: the first tables."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables. Written out here: what `tables` says will go on changing."""
    op.create_table(
        "boards",
        sa.Column("digest", sa.String(64), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("json", sa.Text, nullable=False),
    )
    op.create_table(
        "rooms",
        sa.Column("number", sa.BigInteger().with_variant(sa.Integer, "sqlite"), primary_key=True),
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("board", sa.String(64), sa.ForeignKey("boards.digest"), nullable=False),
        sa.Column("mode", sa.String(16), nullable=False),
        sa.Column("owned", sa.Boolean, nullable=False),
        sa.Column("tick_rate", sa.Integer, nullable=False),
        sa.Column("physics_version", sa.Integer, nullable=False),
        sa.Column("opened", sa.Double, nullable=False),
        sa.Column("used", sa.Double, nullable=False),
        sa.Column("closed", sa.Double),
        sa.Column("awake", sa.Boolean, nullable=False),
        sa.Column("tick", sa.BigInteger, nullable=False),
        sa.Column("checkpoint", sa.LargeBinary),
        sa.Column("checkpoint_drops", sa.BigInteger, nullable=False),
    )
    _partial_index("rooms_open", "id", "closed IS NULL", unique=True)
    _partial_index("rooms_awake", "number", "awake AND closed IS NULL")
    _partial_index("rooms_used", "used", "closed IS NULL")
    op.create_table(
        "drops",
        sa.Column("room", sa.BigInteger, sa.ForeignKey("rooms.number"), primary_key=True),
        sa.Column("ball", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("tick", sa.BigInteger, nullable=False),
        sa.Column("seed", sa.String(20), nullable=False),
        sa.Column("x", sa.Double),
        sa.Column("stake", sa.BigInteger, nullable=False),
        sa.Column("who", sa.String(64)),
        sa.CheckConstraint("stake >= 0", name="drops_stake"),
    )
    op.create_table(
        "results",
        sa.Column("room", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("ball", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("tick", sa.BigInteger, nullable=False),
        sa.Column("bin", sa.Integer),
        sa.Column("score", sa.Double, nullable=False),
        sa.Column("t", sa.Double, nullable=False),
        sa.Column("x_end", sa.Double, nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("unsettled", sa.Text),
        sa.Column("payout", sa.BigInteger, nullable=False),
        sa.ForeignKeyConstraint(["room", "ball"], ["drops.room", "drops.ball"]),
        sa.CheckConstraint("payout >= 0", name="results_payout"),
    )
    op.create_table(
        "probes",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("filler", sa.LargeBinary, nullable=False),
    )


def _partial_index(name: str, column: str, where: str, *, unique: bool = False) -> None:
    condition = sa.text(where)
    op.create_index(
        name,
        "rooms",
        [column],
        unique=unique,
        sqlite_where=condition,
        postgresql_where=condition,
    )
