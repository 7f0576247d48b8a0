"""The ledger's tables, as a new ledger gets them.

Each change here also needs a step in `ledger/migrations/versions`, for ledgers of earlier releases.
"""

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
    PrimaryKeyConstraint,
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
    """The id of a room or fair session, as clients send it.

    A client may send a NUL, which PostgreSQL's text cannot contain: the statement would fail as if
    the database were lost. It is replaced by U+FFFD. No id contains either, so the lookup finds
    nothing, as it should.
    """

    impl = String(64)
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        return None if value is None else value.replace("\0", "\ufffd")


class Seed(TypeDecorator[int]):
    """A seed of 64 bits as a signed integer: no database has an unsigned one."""

    impl = BigInteger
    cache_ok = True

    def process_bind_param(self, value: int | None, dialect: Dialect) -> int | None:
        return None if value is None else value - (value >> 63 << 64)

    def process_result_value(self, value: int | None, dialect: Dialect) -> int | None:
        # SQLite returns whatever a damaged row contains.
        return value % (1 << 64) if isinstance(value, int) else value


class Hex(TypeDecorator[str]):
    """Hexadecimal text, such as a digest, as its bytes."""

    impl = LargeBinary
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> bytes | None:
        return None if value is None else bytes.fromhex(value)

    def process_result_value(self, value: bytes | None, dialect: Dialect) -> str | None:
        return value.hex() if isinstance(value, bytes) else value


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

GREAT = "score >= 10"
"""The condition of the index `results_great`; a query that uses it must contain it literally."""

# One row for each run of a room. A room that is reset or gets another board gets a new row with the
# same `id`, so that a row's log is that of one world from tick 0 on.
rooms = Table(
    "rooms",
    metadata,
    # 64 bits in PostgreSQL; SQLite assigns numbers only if the type is INTEGER.
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
    # Whether something moves, or drops may have no result yet.
    Column("awake", Boolean, nullable=False),
    Column("tick", BigInteger, nullable=False),  # of the last mark
    # For touching balls, the world from which a replay starts (NULL: an empty world), and its
    # number of inputs; for a table, its number of drops.
    Column("checkpoint", LargeBinary),
    Column("checkpoint_drops", BigInteger, nullable=False),
    # A mark that only tells creators apart.
    Column("creator", String(64)),
    Column("draw", String(64)),  # digest of its draw, if it has one
    Column("rules", Integer, nullable=False, server_default="1"),  # see records.RULES
    # Drops below this number are deleted, except those of open fair sessions; see retention.py.
    Column("pruned", BigInteger, nullable=False, server_default="0"),
    Index("rooms_open", "id", unique=True, sqlite_where=text("closed IS NULL"),
          postgresql_where=text("closed IS NULL")),
    Index("rooms_awake", "number", sqlite_where=text("awake AND closed IS NULL"),
          postgresql_where=text("awake AND closed IS NULL")),
    Index("rooms_used", "used", sqlite_where=text("closed IS NULL"),
          postgresql_where=text("closed IS NULL")),
)  # fmt: skip

# The marks that players send with their drops. Without a mark, the player is erased.
players = Table(
    "players",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("who", String(64), unique=True),
)

drops = Table(
    "drops",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("ball", BigInteger, primary_key=True, autoincrement=False),
    Column("tick", BigInteger, nullable=False),
    Column("seed", Seed, nullable=False),
    Column("x", Double),  # m, if the player chose the start
    Column("stake", BigInteger, nullable=False),  # minor units
    Column("player", Integer, ForeignKey("players.number")),
    Column("aim", Double),  # m, if the player chose the middle of the seed's range
    Column("practice", Boolean, nullable=False),  # whether the player chose the seed or x
    # Shown to spectators; no digest covers these.
    Column("name", Text),
    Column("colour", String(7)),
    CheckConstraint("stake >= 0", name="drops_stake"),
    Index("drops_player", "player", sqlite_where=text("player IS NOT NULL"),
          postgresql_where=text("player IS NOT NULL")),
    sqlite_with_rowid=False,
)  # fmt: skip

# All inputs of rooms whose balls touch each other, including drops: a replay needs nothing else.
inputs = Table(
    "inputs",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    Column("tick", BigInteger, nullable=False),
    Column("data", Text, nullable=False),  # JSON
    Column("who", String(64)),
)

# The idempotency keys that callers have used, and what their first requests have made; see
# app/rooms/keys.py. `id` is a hash of scope and key. Old rows are deleted; see retention.py.
idempotency_keys = Table(
    "idempotency_keys",
    metadata,
    Column("number", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", LargeBinary(16), nullable=False, unique=True),
    Column("request", LargeBinary(16), nullable=False),
    Column("run", BigInteger, nullable=False),
    Column("fact", String(64), nullable=False),
    Column("own", Boolean, nullable=False),  # whether it is a key of a queue's ball
    Column("used", BigInteger, nullable=False),  # Unix time, s
)

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
    Column("digest", Hex, nullable=False),
    Column("unsettled", Text),
    Column("payout", BigInteger, nullable=False),  # minor units
    ForeignKeyConstraint(["room", "ball"], ["drops.room", "drops.ball"]),
    CheckConstraint("payout >= 0", name="results_payout"),
    # About one result in a hundred: the best of a day are found among them.
    Index("results_great", "room", "tick", sqlite_where=text(GREAT), postgresql_where=text(GREAT)),
    sqlite_with_rowid=False,
)

# The number of a run's results by bin, so that no table has to be counted; -1: no bin.
tallies = Table(
    "tallies",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("bin", Integer, primary_key=True, autoincrement=False),
    Column("results", BigInteger, nullable=False),
)

# Fair sessions: both secrets and the signatures in hexadecimal, the signed statements as JSON.
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
    Column("end", Text),  # JSON; NULL until the session ends
    Column("end_signature", String(128)),
)

# The log of all receipts, numbered without gaps. A receipt's other fields are those of its drop and
# its session. A row goes with its drop, and its hash stays in `log_nodes`.
receipts = Table(
    "receipts",
    metadata,
    Column("leaf", BigInteger, primary_key=True, autoincrement=False),
    Column("session", Id, ForeignKey("fair_sessions.id"), nullable=False),
    Column("number", BigInteger, nullable=False),
    Column("room", BigInteger, nullable=False),
    Column("ball", BigInteger, nullable=False),
    Column("time", BigInteger, nullable=False),  # Unix time, ms
    Column("root", Hex, nullable=False),  # of the log with this leaf
    Column("signature", Hex, nullable=False),
    UniqueConstraint("session", "number", name="receipts_number"),
    UniqueConstraint("room", "ball", name="receipts_ball"),
    sqlite_with_rowid=False,
)

# The log's complete subtrees (RFC 6962): `number` spans 2^level leaves from number * 2^level on.
log_nodes = Table(
    "log_nodes",
    metadata,
    Column("level", Integer, primary_key=True, autoincrement=False),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    Column("hash", Hex, nullable=False),
    sqlite_with_rowid=False,
)

# Sums of stakes and payouts by board and the stake's power of ten; see totals.py.
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

# The log of the operator's actions, from which follows what is in force; see app/live/orders.py.
operator_actions = Table(
    "operator_actions",
    metadata,
    Column("number", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("action", String(16), nullable=False),
    Column("subject", String(64), nullable=False),
    Column("time", Double, nullable=False),  # Unix time, s
    Column("text", Text),
    Column("until", Double),  # Unix time, s
)

# What a webhook's target has received of a table's run: its drops below `next`, and their landings
# but for the balls in `flying`, a JSON list.
webhook_cursors = Table(
    "webhook_cursors",
    metadata,
    Column("target", Text, primary_key=True),
    Column("run", BigInteger, primary_key=True, autoincrement=False),
    Column("next", BigInteger, nullable=False),
    Column("flying", Text, nullable=False),
)

# A run's queue of drops as JSON: its items, and whether it is paused.
queues = Table(
    "queues",
    metadata,
    Column("room", BigInteger, ForeignKey("rooms.number"), primary_key=True, autoincrement=False),
    Column("data", Text, nullable=False),
)

# What the stage of a room shows beside the board, by the room's id: see web/routes/rooms/shows.py.
shows = Table(
    "shows",
    metadata,
    Column("room", Id, primary_key=True),
    Column("data", Text, nullable=False),  # JSON
    Column("updated", Double, nullable=False),  # Unix time, s
)

# Leases: which server has a room, if several share the ledger. `number` is the fencing number: it
# grows with every lease, and a write must find the number of its lease here. A `holder` of "" means
# that no server has the room.
leases = Table(
    "holds",
    metadata,
    Column("room", Id, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("holder", Text, nullable=False),
    Column("address", Text, nullable=False),  # where other servers reach the holder
    Column("taken", Double, nullable=False),  # Unix time, s
)

# Counters that servers share, each with its next free number; some rows serve only as locks.
counters = Table(
    "counters",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("next", BigInteger, nullable=False),
)

# The starts of servers that write to the ledger, each with the number of its last batch, and in
# `epoch` the number of its reconnections after a commit without an answer; see ledger/epoch.py.
writers = Table(
    "writers",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("batch", BigInteger, nullable=False),
    Column("epoch", BigInteger, nullable=False),
    Column("former", String(32)),  # the server's epoch before; NULL in release 1.0
)

# Restores of backups, each of which began log `number` of the receipts; see history.py.
restores = Table(
    "restores",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("log", String(32), nullable=False),
    Column("superseded", String(32)),
    Column("statement", Text, nullable=False),  # JSON
    Column("signature", String(128), nullable=False),
)

# Public keys of this ledger's statements, past and present, and marks of its tokens' secrets.
keys = Table(
    "keys",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("name", String(32), nullable=False),
    Column("value", String(64), nullable=False),
    Column("since", Double, nullable=False),  # Unix time, s
    Column("statement", Text),  # JSON
    Column("signature", String(128)),
    Column("former_signature", String(128)),
)

# The signing secrets of servers that share the ledger, in hexadecimal.
secrets = Table(
    "secrets",
    metadata,
    Column("name", String(32), primary_key=True),
    Column("value", Text, nullable=False),
)

# A row is written and deleted again to test whether the ledger accepts a page of data.
probes = Table(
    "probes",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("filler", LargeBinary, nullable=False),
)

# The migration step of the tables; Alembic's own table.
revision = Table(
    "alembic_version",
    metadata,
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)


def replacing(
    connection: Connection, table: Table, *, sums: bool = False
) -> postgresql.Insert | sqlite.Insert:
    """An insert that replaces the rows with the same keys; with `sums` it adds to their values."""
    new, keys = adding(connection, table), [column.name for column in table.primary_key]
    values = {
        column.name: column + new.excluded[column.name] if sums else new.excluded[column.name]
        for column in table.c
        if column.name not in keys
    }
    return new.on_conflict_do_update(index_elements=keys, set_=values)


def adding(connection: Connection, table: Table) -> postgresql.Insert | sqlite.Insert:
    """An insert of the connection's dialect, with its `on_conflict_…` methods."""
    if connection.dialect.name == "postgresql":
        return postgresql.insert(table)
    return sqlite.insert(table)
