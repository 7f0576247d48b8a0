"""The ledger's tables. A change here needs a step in `migrations/versions` as well."""

from sqlalchemy import (
    BigInteger,
    Boolean,
    CheckConstraint,
    Column,
    Connection,
    Dialect,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
    UniqueConstraint,
    text,
)
from sqlalchemy.dialects import postgresql, sqlite

metadata = MetaData()


class Id(TypeDecorator[str]):
    """What clients name rooms and sessions by.

    PostgreSQL's text cannot hold a NUL: it fails as if the database were lost. An id has none, so
    what is asked for by one is looked up under a character that no id has either.
    """

    impl = String(64)
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        """The id as a database can look it up."""
        return None if value is None else value.replace("\0", "\ufffd")


boards = Table(
    "boards",
    metadata,
    Column("digest", String(64), primary_key=True),
    Column("name", Text, nullable=False),
    Column("json", Text, nullable=False),
)

# Draws of rooms: weights of bins and seeds, over a board, as canonical JSON.
draws = Table(
    "draws",
    metadata,
    Column("digest", String(64), primary_key=True),
    Column("json", Text, nullable=False),
)

# One row for each run of a room: `id` is what the world calls it, and it gets a new row when
# it is reset or given another board, so that a row's log is that of one world from tick 0 on.
rooms = Table(
    "rooms",
    metadata,
    # 64 bits in PostgreSQL; SQLite numbers rows by itself only where the type is INTEGER.
    Column("number", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", Id, nullable=False),
    Column("board", String(64), ForeignKey("boards.digest"), nullable=False),
    Column("mode", String(16), nullable=False),
    Column("owned", Boolean, nullable=False),
    Column("tick_rate", Integer, nullable=False),
    Column("physics_version", Integer, nullable=False),
    Column("opened", Double, nullable=False),  # Unix time, s
    Column("used", Double, nullable=False),  # Unix time, s
    Column("closed", Double),  # Unix time, s
    # Whether something moved or waited to move when the ledger last heard.
    Column("awake", Boolean, nullable=False),
    # No tick after this one was shown to anyone; a rebuilt room goes on from here.
    Column("tick", BigInteger, nullable=False),
    # A world to start the replay from, and how many drops it has taken; NULL: an empty one.
    Column("checkpoint", LargeBinary),
    Column("checkpoint_drops", BigInteger, nullable=False),
    # Who made it, as a mark that says no more; where several servers share the ledger.
    Column("creator", String(64)),
    Column("key", String(64)),  # of the request that began this run, by which it may be asked again
    Column("draw", String(64)),  # digest of its draw, if it has one
    Index("rooms_key", "key", unique=True,
          sqlite_where=text("key IS NOT NULL AND closed IS NULL"),
          postgresql_where=text("key IS NOT NULL AND closed IS NULL")),
    Index("rooms_open", "id", unique=True, sqlite_where=text("closed IS NULL"),
          postgresql_where=text("closed IS NULL")),
    Index("rooms_awake", "number", sqlite_where=text("awake AND closed IS NULL"),
          postgresql_where=text("awake AND closed IS NULL")),
    Index("rooms_used", "used", sqlite_where=text("closed IS NULL"),
          postgresql_where=text("closed IS NULL")),
)  # fmt: skip

drops = Table(
    "drops",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("ball", BigInteger, primary_key=True, autoincrement=False),
    Column("tick", BigInteger, nullable=False),
    # Decimal: a seed may need 64 bits without a sign, which no database's integer has.
    Column("seed", String(20), nullable=False),
    Column("x", Double),  # m, where the player chose it
    Column("stake", BigInteger, nullable=False),  # minor units
    Column("who", String(64)),
    Column("aim", Double),  # m, where the player chose the middle of what the seed draws
    Column("practice", Boolean, nullable=False),  # chosen seed or x
    # By which it may be asked for again; a client may use one again, and the last counts.
    Column("key", String(64)),
    # For those who watch; no digest covers them.
    Column("name", Text),
    Column("colour", String(7)),
    CheckConstraint("stake >= 0", name="drops_stake"),
    Index("drops_key", "room", "key", sqlite_where=text("key IS NOT NULL"),
          postgresql_where=text("key IS NOT NULL")),
    Index("drops_who", "who", sqlite_where=text("who IS NOT NULL"),
          postgresql_where=text("who IS NOT NULL")),
)  # fmt: skip

# What rooms were told whose balls touch each other, drops included: such a room follows from it.
inputs = Table(
    "inputs",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    Column("tick", BigInteger, nullable=False),
    Column("data", Text, nullable=False),  # JSON
    Column("who", String(64)),
    # By which it may be asked for again; a client may use one again, and the last counts.
    Column("key", String(64)),
    Index("inputs_key", "room", "key", sqlite_where=text("key IS NOT NULL"),
          postgresql_where=text("key IS NOT NULL")),
)  # fmt: skip

results = Table(
    "results",
    metadata,
    Column("room", BigInteger, primary_key=True, autoincrement=False),
    Column("ball", BigInteger, primary_key=True, autoincrement=False),
    Column("tick", BigInteger, nullable=False),
    Column("bin", Integer),
    Column("score", Double, nullable=False),
    Column("t", Double, nullable=False),  # s
    Column("x_end", Double, nullable=False),  # m
    Column("digest", String(64), nullable=False),
    Column("unsettled", Text),
    Column("payout", BigInteger, nullable=False),  # minor units
    ForeignKeyConstraint(["room", "ball"], ["drops.room", "drops.ball"]),
    CheckConstraint("payout >= 0", name="results_payout"),
)

# A player's session: both secrets, and what was signed of it, as JSON. Hexadecimal throughout.
fair_sessions = Table(
    "fair_sessions",
    metadata,
    Column("id", Id, primary_key=True),
    Column("room", Id, nullable=False),
    Column("board", String(64), ForeignKey("boards.digest"), nullable=False),
    Column("server_seed", String(64), nullable=False),
    Column("client_seed", String(64)),  # NULL until the player opens it
    Column("statement", Text, nullable=False),
    Column("signature", String(128), nullable=False),
    Column("opened", Double, nullable=False),  # Unix time, s
    Column("end", Text),  # NULL while it goes on
    Column("end_signature", String(128)),
)

# The log of all receipts, numbered without gaps; a row is never changed, and none goes away with
# the room it is of.
receipts = Table(
    "receipts",
    metadata,
    Column("leaf", BigInteger, primary_key=True, autoincrement=False),
    Column("session", Id, ForeignKey("fair_sessions.id"), nullable=False),
    Column("number", BigInteger, nullable=False),
    Column("room", BigInteger, nullable=False),
    Column("ball", BigInteger, nullable=False),
    Column("receipt", Text, nullable=False),  # JSON
    Column("root", String(64), nullable=False),  # of the log with this leaf
    Column("signature", String(128), nullable=False),
    UniqueConstraint("session", "number", name="receipts_number"),
    UniqueConstraint("room", "ball", name="receipts_ball"),
)

# The log's complete subtrees (RFC 6962): `number` spans 2^level leaves from number * 2^level on.
log_nodes = Table(
    "log_nodes",
    metadata,
    Column("level", Integer, primary_key=True, autoincrement=False),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    Column("hash", String(64), nullable=False),
)

# What was staked and paid in all, by board and power of ten of the stake: `totals` says of what.
totals = Table(
    "totals",
    metadata,
    Column("board", String(64), primary_key=True),
    Column("stake", BigInteger, primary_key=True, autoincrement=False),
    Column("aimed", Boolean, primary_key=True),
    Column("plays", BigInteger, nullable=False),
    Column("staked", BigInteger, nullable=False),  # minor units
    Column("squares", Double, nullable=False),  # of the stakes
    Column("paid", BigInteger, nullable=False),  # minor units
)

# Rooms that take nothing new, by id; `*` for all of them.
halts = Table(
    "halts",
    metadata,
    Column("room", Id, primary_key=True),
    Column("since", Double, nullable=False),  # Unix time, s
)

# What targets of webhooks have not heard yet: that a ball was accepted, or has landed.
webhooks = Table(
    "webhooks",
    metadata,
    Column("number", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("target", Text, nullable=False),
    Column("room", BigInteger, nullable=False),
    Column("ball", BigInteger, nullable=False),
    Column("event", String(8), nullable=False),
    ForeignKeyConstraint(["room", "ball"], ["drops.room", "drops.ball"]),
    Index("webhooks_target", "target", "number"),
    Index("webhooks_ball", "room", "ball"),
    sqlite_autoincrement=True,  # else the number of the last one would be given again
)

# What waits to be dropped in a run of a room, as JSON: its items, and whether they are paused.
queues = Table(
    "queues",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("data", Text, nullable=False),
)

# Which server has a room, where several share the ledger. `number` grows with every change of
# hands and is what a write must still find here; a `holder` of "" is nobody.
leases = Table(
    "holds",
    metadata,
    Column("room", Id, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("holder", Text, nullable=False),
    Column("address", Text, nullable=False),  # where the other servers reach it
    Column("taken", Double, nullable=False),  # Unix time, s
)

# What servers number together: the next number that none of them has, and rows to lock by.
counters = Table(
    "counters",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("next", BigInteger, nullable=False),
)

# Who writes to the ledger: the number of its last batch, and how often it has connected anew after
# a commit that was not answered.
writers = Table(
    "writers",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("batch", BigInteger, nullable=False),
    Column("epoch", BigInteger, nullable=False),
)

# What servers that share the ledger sign with, in hexadecimal.
secrets = Table(
    "secrets",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("value", Text, nullable=False),
)

# Written and emptied again to find out whether the ledger takes a page's worth of data now.
probes = Table(
    "probes",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("filler", LargeBinary, nullable=False),
)


def adding(connection: Connection, table: Table) -> postgresql.Insert | sqlite.Insert:
    """An insert into a table that can say what becomes of rows that are there already."""
    if connection.dialect.name == "postgresql":
        return postgresql.insert(table)
    return sqlite.insert(table)
