"""Unit costs that no other benchmark measures: a room's ticks, its memory, its rows in a ledger."""

import contextlib
import gc
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

from benchmarks.harness.clock import Job, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import processor_time
from plinko.engine import Board

BOARD: Final = "triangle-16"
BALLS: Final = (1, 8, 50)
"""Balls in flight in one room: of one player, of a few, of a crowd."""

TICKS: Final = 120
GROUP: Final = 100
"""Drops per transaction: as many as reach a busy server while it commits the last transaction."""

ROOM: Final = "A room by the balls in flight in it"
LEDGER: Final = "What a ledger takes"


def run(effort: Effort) -> Section:
    section = Section("scale")
    _rooms(section, effort)
    _ledger(section, effort)
    return section


def _rooms(section: Section, effort: Effort) -> None:
    """The time of a tick, and the memory of a room with its balls."""
    times = in_turns(
        {str(balls): _ticking(balls) for balls in BALLS},
        effort.rounds,
        lambda: effort.step("rooms"),
    )
    memory = {str(balls): _memory(balls, effort.size(50, 3)) for balls in (0, *BALLS)}
    section.data["rooms"] = {name: sample.to_dict() for name, sample in times.items()}
    section.data["room_bytes"] = memory
    rows = [["0", "", f"{memory['0']:,.0f}"]]
    rows += [
        [name, spread(sample.map(lambda s: 1e6 * s), "{:.1f}"), f"{memory[name]:,.0f}"]
        for name, sample in times.items()
    ]
    section.tables.append(
        Table(
            ROOM,
            ["balls", "µs a tick", "bytes"],
            rows,
            [
                f"{BOARD}, processor time of a tick of physics and events, over the first {TICKS} "
                "ticks of balls that were dropped at once; memory of the room's objects and arrays "
                "with its board, as Python's allocators count it. A room asleep has no tick."
            ],
        )
    )


def _room(balls: int) -> Any:
    from plinko.app.rooms.independent import IndependentRoom
    from plinko.app.rooms.pending import DropCommand

    room = IndependentRoom("bench", Board.preset(BOARD), tick_rate=60, max_balls=max(BALLS))
    for seed in range(balls):
        room.drop(DropCommand(seed))
    return room


def _ticking(balls: int) -> Job:
    def ticks() -> float:
        room = _room(balls)

        def work() -> None:
            for _ in range(TICKS):
                room.step(watched=False)

        return seconds_of(work, time.process_time) / TICKS

    return ticks


def _memory(balls: int, rooms: int) -> float:
    """Bytes of a room with balls in flight, the mean of several rooms."""
    _room(balls).step(watched=False)  # allocates what all rooms share
    gc.collect()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        held = [_room(balls) for _ in range(rooms)]
        for room in held:
            room.step(watched=False)
        return (tracemalloc.get_traced_memory()[0] - before) / rooms
    finally:
        tracemalloc.stop()


def _ledger(section: Section, effort: Effort) -> None:
    """The cost of drops with results, and of marks of a room's progress, in both databases."""
    drops = effort.size(20_000, GROUP)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        found["SQLite"] = _costs(f"sqlite:///{Path(folder) / 'bench.db'}", drops, effort)
    with postgresql() as url:
        if url is None:
            section.absent.append("PostgreSQL: its server programs are not here")
        else:
            found["PostgreSQL"] = _costs(url, drops, effort)
    section.data["ledger"] = found
    section.tables.append(
        Table(
            LEDGER,
            ["database", "µs a drop", "µs a mark", "bytes a drop"],
            [
                [name, f"{each['drop']:.0f}", f"{each['mark']:.0f}", f"{each['bytes']:.0f}"]
                for name, each in found.items()
            ],
            [
                f"{drops:,} drops of one room, each with its result, and as many marks of how far "
                f"rooms have come, {GROUP} in a transaction: processor time of the server's thread "
                "and of the database together. They take turns, so it is also what one ledger "
                "takes at least; its disk comes on top. Bytes: the growth of the database by a "
                "drop and its result, indexes included."
            ],
        )
    )


def _costs(url: str, drops: int, effort: Effort) -> dict[str, float]:
    """µs of a drop with its result, µs of a mark, and bytes of a drop."""
    from plinko.app.persistence.ledger.database import Database
    from plinko.app.persistence.statements import writing
    from plinko.app.rooms.pending import DropCommand
    from plinko.app.rooms.records import BoardRow, Mark, NewDrop, ResultRow, RoomRow, Write

    board = BoardRow("b" * 64, "bench", "{}")
    rooms = [
        RoomRow(n, str(n), board.digest, "independent", True, 60, 1, 0.0, 0.0)
        for n in range(1, GROUP + 1)
    ]
    database = Database(url)
    database.open()
    try:
        with database.transaction() as connection:
            writing.apply(connection, [board, *rooms])
        before, backend = database_size(database), _backend(database)

        def timed(rows: Callable[[int], list[Write]]) -> float:
            began = _worked(backend)
            for first in range(0, drops, GROUP):
                with database.transaction() as connection:
                    writing.apply(connection, rows(first))
                effort.step("ledger")
            return (_worked(backend) - began) * 1e6 / drops

        def dropped(first: int) -> list[Write]:
            balls = range(first, first + GROUP)
            taken = [NewDrop(1, ball, DropCommand(ball), used=0.0) for ball in balls]
            ended = [ResultRow(1, b, b, 3, 1.0, 4.6, 0.1, f"{b:064x}", None) for b in balls]
            return [*taken, *ended]

        spent = timed(dropped)
        grown = database_size(database) - before
        marked = timed(lambda tick: [Mark(n, tick, True, 0.0) for n in range(1, GROUP + 1)])
    finally:
        database.close()
    return {"drop": spent, "mark": marked, "bytes": grown / drops}


def _backend(database: Any) -> int | None:
    """PostgreSQL's process for this connection; None for SQLite, which runs in this process."""
    import sqlalchemy as sa

    if database.file is not None:
        return None
    with database.transaction() as connection:
        return int(connection.scalar(sa.text("SELECT pg_backend_pid()")))


def _worked(backend: int | None) -> float:
    """Processor time of this process and of the database's process until now, s."""
    return time.process_time() + (processor_time(backend) if backend else 0.0)


def database_size(database: Any) -> float:
    """Bytes of the whole database, indexes included."""
    import sqlalchemy as sa

    with database.transaction() as connection:
        if database.file is None:
            return float(connection.scalar(sa.text("SELECT pg_database_size(current_database())")))
        pages = connection.scalar(sa.text("PRAGMA page_count"))
        return float(pages * connection.scalar(sa.text("PRAGMA page_size")))


@contextlib.contextmanager
def postgresql() -> Iterator[str | None]:
    """The address of an empty database; None if PostgreSQL is not installed."""
    from tests.kit import postgres

    if postgres.why_not():
        yield None
        return
    with postgres.running() as postgresql:
        yield postgresql.new_database()
