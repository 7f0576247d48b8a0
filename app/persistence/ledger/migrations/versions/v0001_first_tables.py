"""Create all tables of the first release."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables. They are written out here, because `statements.tables` will change."""
    op.create_table(
        "boards",
        sa.Column("digest", sa.String(length=64), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("json", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("digest"),
    )
    op.create_table(
        "counters",
        sa.Column("name", sa.String(length=32), nullable=False),
        sa.Column("next", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("name"),
    )
    op.create_table(
        "halts",
        sa.Column("room", sa.String(length=64), nullable=False),
        sa.Column("since", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("room"),
    )
    op.create_table(
        "holds",
        sa.Column("room", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("holder", sa.Text(), nullable=False),
        sa.Column("address", sa.Text(), nullable=False),
        sa.Column("taken", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("room"),
    )
    op.create_table(
        "log_nodes",
        sa.Column("level", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("number", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("hash", sa.String(length=64), nullable=False),
        sa.PrimaryKeyConstraint("level", "number"),
    )
    op.create_table(
        "probes",
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("filler", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("number"),
    )
    op.create_table(
        "secrets",
        sa.Column("name", sa.String(length=32), nullable=False),
        sa.Column("value", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("name"),
    )
    op.create_table(
        "totals",
        sa.Column("board", sa.String(length=64), nullable=False),
        sa.Column("stake", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("aimed", sa.Boolean(), nullable=False),
        sa.Column("plays", sa.BigInteger(), nullable=False),
        sa.Column("staked", sa.BigInteger(), nullable=False),
        sa.Column("squares", sa.Double(), nullable=False),
        sa.Column("paid", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("board", "stake", "aimed"),
    )
    op.create_table(
        "writers",
        sa.Column("name", sa.String(length=32), nullable=False),
        sa.Column("batch", sa.BigInteger(), nullable=False),
        sa.Column("epoch", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("name"),
    )
    op.create_table(
        "fair_sessions",
        sa.Column("id", sa.String(length=64), nullable=False),
        sa.Column("room", sa.String(length=64), nullable=False),
        sa.Column("board", sa.String(length=64), nullable=False),
        sa.Column("server_seed", sa.String(length=64), nullable=False),
        sa.Column("client_seed", sa.String(length=64), nullable=True),
        sa.Column("statement", sa.Text(), nullable=False),
        sa.Column("signature", sa.String(length=128), nullable=False),
        sa.Column("opened", sa.Double(), nullable=False),
        sa.Column("end", sa.Text(), nullable=True),
        sa.Column("end_signature", sa.String(length=128), nullable=True),
        sa.ForeignKeyConstraint(
            ["board"],
            ["boards.digest"],
        ),
        sa.PrimaryKeyConstraint("id"),
    )
    op.create_table(
        "rooms",
        sa.Column("number", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("id", sa.String(length=64), nullable=False),
        sa.Column("board", sa.String(length=64), nullable=False),
        sa.Column("mode", sa.String(length=16), nullable=False),
        sa.Column("owned", sa.Boolean(), nullable=False),
        sa.Column("tick_rate", sa.Integer(), nullable=False),
        sa.Column("physics_version", sa.Integer(), nullable=False),
        sa.Column("opened", sa.Double(), nullable=False),
        sa.Column("used", sa.Double(), nullable=False),
        sa.Column("closed", sa.Double(), nullable=True),
        sa.Column("awake", sa.Boolean(), nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("checkpoint", sa.LargeBinary(), nullable=True),
        sa.Column("checkpoint_drops", sa.BigInteger(), nullable=False),
        sa.Column("creator", sa.String(length=64), nullable=True),
        sa.Column("key", sa.String(length=64), nullable=True),
        sa.ForeignKeyConstraint(
            ["board"],
            ["boards.digest"],
        ),
        sa.PrimaryKeyConstraint("number"),
    )
    op.create_index(
        "rooms_awake",
        "rooms",
        ["number"],
        unique=False,
        sqlite_where=sa.text("awake AND closed IS NULL"),
        postgresql_where=sa.text("awake AND closed IS NULL"),
    )
    op.create_index(
        "rooms_key",
        "rooms",
        ["key"],
        unique=True,
        sqlite_where=sa.text("key IS NOT NULL AND closed IS NULL"),
        postgresql_where=sa.text("key IS NOT NULL AND closed IS NULL"),
    )
    op.create_index(
        "rooms_open",
        "rooms",
        ["id"],
        unique=True,
        sqlite_where=sa.text("closed IS NULL"),
        postgresql_where=sa.text("closed IS NULL"),
    )
    op.create_index(
        "rooms_used",
        "rooms",
        ["used"],
        unique=False,
        sqlite_where=sa.text("closed IS NULL"),
        postgresql_where=sa.text("closed IS NULL"),
    )
    op.create_table(
        "drops",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("ball", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("seed", sa.String(length=20), nullable=False),
        sa.Column("x", sa.Double(), nullable=True),
        sa.Column("stake", sa.BigInteger(), nullable=False),
        sa.Column("who", sa.String(length=64), nullable=True),
        sa.Column("aim", sa.Double(), nullable=True),
        sa.Column("practice", sa.Boolean(), nullable=False),
        sa.Column("key", sa.String(length=64), nullable=True),
        sa.CheckConstraint("stake >= 0", name="drops_stake"),
        sa.ForeignKeyConstraint(
            ["room"],
            ["rooms.number"],
        ),
        sa.PrimaryKeyConstraint("room", "ball"),
    )
    op.create_index(
        "drops_key",
        "drops",
        ["room", "key"],
        unique=False,
        sqlite_where=sa.text("key IS NOT NULL"),
        postgresql_where=sa.text("key IS NOT NULL"),
    )
    op.create_index(
        "drops_who",
        "drops",
        ["who"],
        unique=False,
        sqlite_where=sa.text("who IS NOT NULL"),
        postgresql_where=sa.text("who IS NOT NULL"),
    )
    op.create_table(
        "inputs",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("number", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("data", sa.Text(), nullable=False),
        sa.Column("who", sa.String(length=64), nullable=True),
        sa.Column("key", sa.String(length=64), nullable=True),
        sa.ForeignKeyConstraint(
            ["room"],
            ["rooms.number"],
        ),
        sa.PrimaryKeyConstraint("room", "number"),
    )
    op.create_index(
        "inputs_key",
        "inputs",
        ["room", "key"],
        unique=False,
        sqlite_where=sa.text("key IS NOT NULL"),
        postgresql_where=sa.text("key IS NOT NULL"),
    )
    op.create_table(
        "receipts",
        sa.Column("leaf", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("session", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("room", sa.BigInteger(), nullable=False),
        sa.Column("ball", sa.BigInteger(), nullable=False),
        sa.Column("receipt", sa.Text(), nullable=False),
        sa.Column("root", sa.String(length=64), nullable=False),
        sa.Column("signature", sa.String(length=128), nullable=False),
        sa.ForeignKeyConstraint(
            ["session"],
            ["fair_sessions.id"],
        ),
        sa.PrimaryKeyConstraint("leaf"),
        sa.UniqueConstraint("room", "ball", name="receipts_ball"),
        sa.UniqueConstraint("session", "number", name="receipts_number"),
    )
    op.create_table(
        "results",
        sa.Column("room", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("ball", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("tick", sa.BigInteger(), nullable=False),
        sa.Column("bin", sa.Integer(), nullable=True),
        sa.Column("score", sa.Double(), nullable=False),
        sa.Column("t", sa.Double(), nullable=False),
        sa.Column("x_end", sa.Double(), nullable=False),
        sa.Column("digest", sa.String(length=64), nullable=False),
        sa.Column("unsettled", sa.Text(), nullable=True),
        sa.Column("payout", sa.BigInteger(), nullable=False),
        sa.CheckConstraint("payout >= 0", name="results_payout"),
        sa.ForeignKeyConstraint(
            ["room", "ball"],
            ["drops.room", "drops.ball"],
        ),
        sa.PrimaryKeyConstraint("room", "ball"),
    )
