"""How large a ledger grows: a million drops written as the server writes them, table by table."""

import hashlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import sqlalchemy as sa

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.scale.units import GROUP, database_size, postgresql
from plinko.app.fairness.seeds import commitment
from plinko.app.fairness.signing import Signer
from plinko.app.fairness.statements import SessionStatement
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import writing
from plinko.app.rooms.canonical import canonical
from plinko.app.rooms.keys import Caller, key_of
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import BoardRow, FairSessionRow, NewDrop, ResultRow, RoomRow, Write
from plinko.engine import Board, drop_many
from plinko.engine.constants import PHYSICS_VERSION

BOARD: Final = Board.preset("triangle-16")
BEGAN: Final = 1.7e9  # Unix time, s
INTERVAL: Final = 52  # ticks between two drops: 100,000 a day
SESSION: Final = 100
"""Drops of a fair session."""

PLAIN: Final = "without a session"
STAKED: Final = "of fair sessions"


def run(effort: Effort) -> Section:
    drops = effort.size(1_000_000, GROUP)
    section = Section("ledger")
    parts: dict[str, dict[str, float]] = {}
    for kind in (PLAIN, STAKED):
        with tempfile.TemporaryDirectory() as folder:
            url = f"sqlite:///{Path(folder) / 'bench.db'}"
            parts[f"SQLite, {kind}"] = grown(url, kind, drops, effort)
        with postgresql() as address:
            if address is None:
                section.absent.append("PostgreSQL: its server programs are not here")
            else:
                parts[f"PostgreSQL, {kind}"] = grown(address, kind, drops, effort)
    section.data["bytes"] = parts
    section.tables.append(_table(parts, drops))
    return section


def _table(parts: dict[str, dict[str, float]], drops: int) -> Table:
    names = sorted({name for each in parts.values() for name in each} - {""})
    shown = [name for name in names if any(each.get(name, 0.0) > 0.5 for each in parts.values())]
    rows = [
        ["all", *(f"{each[''] * drops / 1e9:.3f} GB" for each in parts.values())],
        *([name, *(f"{each.get(name, 0.0):.0f}" for each in parts.values())] for name in shown),
    ]
    notes = (
        f"{drops:,} drops of one room at {BOARD.name} with the results of their flights, written "
        f"{GROUP} in a transaction by the statements of the server's writer, in the order in which "
        f"they would come. First line: the whole. Below: bytes a drop by database table, indexes "
        "included. "
        f"Each player's mark comes with {SESSION} drops. A fair session has {SESSION} drops, and "
        "each drop a stake, a signed receipt with its nodes in the log, and an idempotency key."
    )
    return Table("A million drops in the ledger", ["table", *parts], rows, [notes])


def grown(url: str, kind: str, drops: int, effort: Effort) -> dict[str, float]:
    """Bytes a drop by database table; in total under an empty name."""
    database = Database(url)
    database.open()
    try:
        board = BoardRow(BOARD.digest, BOARD.name, BOARD.to_json())
        place = (1, "main", BOARD.digest, "independent")
        room = RoomRow(*place, False, 60, PHYSICS_VERSION, opened=BEGAN, used=BEGAN)
        with database.batch() as connection:
            writing.apply(connection, [board, room])
        total, tables = database_size(database), _tables(database)
        play = _Play(Signer(b"s" * 32) if kind == STAKED else None)
        for first in range(0, drops, GROUP):
            with database.batch() as connection:
                writing.apply(connection, play.writes(first))
            effort.step(f"{url.partition(':')[0]}, {kind}: {first:,}")
        with database.batch() as connection:
            writing.apply(connection, play.landed)
        grown = {name: size - tables.get(name, 0) for name, size in _tables(database).items()}
        grown[""] = database_size(database) - total
    finally:
        database.close()
    return {name: size / drops for name, size in grown.items()}


def _tables(database: Database) -> dict[str, float]:
    """Bytes of each database table, indexes included."""
    if database.file is None:
        chosen = "SELECT relname, pg_total_relation_size(relid) FROM pg_stat_user_tables"
    else:
        chosen = (
            "SELECT tbl_name, sum(pgsize) FROM dbstat('main', 1) "
            "JOIN sqlite_schema USING (name) GROUP BY tbl_name"
        )
    with database.transaction() as connection:
        return {name: float(size) for name, size in connection.execute(sa.text(chosen))}


class _Play:
    """Drops in the order in which players make them; with a `signer`, those of fair sessions.

    landed: the results of the last drops, which are written with the next ones.
    """

    def __init__(self, signer: Signer | None) -> None:
        self.signer = signer
        self.landed: list[ResultRow] = []

    def writes(self, first: int) -> list[Write]:
        """The writes of the drops from number `first` on."""
        landed, self.landed = self.landed, self._results(first)
        return [*self._drops(first), *landed]

    def _drops(self, first: int) -> Iterator[Write]:
        session = None
        who = _hash("player", first // SESSION)[:32]
        if self.signer is not None:
            assert SESSION == GROUP
            row, session = self._session(self.signer, first)
            yield row
        for ball in range(first, first + GROUP):
            tick, seed = ball * INTERVAL, int(_hash("seed", ball)[:16], 16)
            now = BEGAN + tick / 60
            if session is None:
                yield NewDrop(1, tick, DropCommand(seed, who=who), used=now)
            else:
                key = key_of("drop", "main", Caller(who), _hash("key", ball), None)
                command = DropCommand(seed, stake=100, who=who)
                yield NewDrop(1, tick, command, now, key, session.turn(None, now))

    def _session(self, signer: Signer, first: int) -> tuple[FairSessionRow, FairSession]:
        secrets = [bytes.fromhex(_hash(name, first)) for name in ("server", "client")]
        now = BEGAN + first * INTERVAL / 60
        began = SessionStatement(
            session=_hash("session", first)[:32],
            room="main",
            board_digest=BOARD.digest,
            payouts_digest=_hash("payouts", 0),
            physics_version=PHYSICS_VERSION,
            kernel_digest=_hash("kernel", 0),
            server_commitment=commitment(secrets[0]).hex(),
            client_commitment=commitment(secrets[1]).hex(),
            time=int(now * 1000.0),
        )
        statement = began.to_dict()
        place = (began.session, "main", BOARD.digest)
        signature, public = signer.sign(statement).hex(), signer.public.hex()
        session = FairSession(
            *place, secrets[0], statement, signature, public, signer, now, secrets[1]
        )
        text = canonical(statement).decode()
        row = FairSessionRow(
            *place, secrets[0].hex(), text, signature, now, client_seed=secrets[1].hex()
        )
        return row, session

    def _results(self, first: int) -> list[ResultRow]:
        many: Any = drop_many(BOARD, range(first, first + GROUP))
        rows = zip(many.bin, many.score, many.duration, many.x_end, strict=True)
        return [
            ResultRow(
                1,
                ball,
                ball * INTERVAL + int(duration * 60),
                int(bin_),
                float(score),
                float(duration),
                float(x_end),
                _hash("digest", ball),
                None,
                0 if self.signer is None else int(100 * score),
            )
            for ball, (bin_, score, duration, x_end) in enumerate(rows, first)
        ]


def _hash(name: str, number: int) -> str:
    return hashlib.sha256(f"{name} {number}".encode()).hexdigest()
