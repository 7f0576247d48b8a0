"""Readers of rooms' logs take turns with rests in between; their number is bounded.

Without that, a hundred readers of a room of 20,000 drops stopped `main`.
"""

import asyncio
import gc
import time
from typing import Any

import msgspec
import pytest

from plinko.app.errors import BusyError, LedgerError, ReadersError
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.room_log import MOST_OF_ONE, MOST_READERS, Entries, LogPage, RoomLogs
from plinko.app.persistence.room_runs import RoomRuns
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.log import lines
from plinko.app.web.routes.rooms.rooms import StreamedAnswer
from plinko.engine import Board

ENTRY = {"ball": 0, "who": "x", "result": None}


class Disk:
    """A ledger with its own clock, on which each page takes 10 ms."""

    def __init__(self) -> None:
        self.leases = LeaseBook()
        self.time = 0.0
        self.rested = 0.0
        self.reading = self.most = 0
        self.broken = False
        self.pages: list[int] = []
        self.runs: list[int] = []  # the room runs of these pages

    async def read(self, entries: Any) -> Entries:
        if self.broken:
            raise LedgerError("the disk is gone")
        self.reading += 1
        self.most = max(self.most, self.reading)
        await asyncio.sleep(0)
        self.time += 0.010
        self.reading -= 1
        page: LogPage = entries.__self__
        self.pages.append(page.limit)
        self.runs.append(page.run)
        found = [ENTRY] * page.limit
        return Entries(page.limit, msgspec.json.encode(found)[1:-1], lines(found))

    def defer(self, writes: Any, done: Any = None) -> None:
        pass

    async def settled(self) -> None:
        pass

    async def sleep(self, seconds: float) -> None:
        self.rested += seconds
        self.time += seconds


def opened(drops: int) -> tuple[RoomLogs, IndependentRoom, Disk]:
    disk = Disk()
    runs = RoomRuns(disk, time.time)  # type: ignore[arg-type]
    runs.begin("r", runs.made(1))
    logs = RoomLogs(runs, clock=lambda: disk.time, sleep=disk.sleep)
    room = IndependentRoom("r", Board.preset("triangle-8"), tick_rate=60, max_balls=10)
    room.drops = drops
    return logs, room, disk


async def whole(logs: RoomLogs, room: IndependentRoom, reader: str) -> dict[str, Any]:
    pieces = [piece async for piece in await logs.read(room, reader, marks=False)]
    found: dict[str, Any] = msgspec.json.decode(b"".join(pieces))
    return found


async def test_a_long_log_is_whole_and_read_in_short_pages_with_rests() -> None:
    logs, room, disk = opened(2100)
    found = await whole(logs, room, "a")
    assert len(found["drops"]) == 2100
    assert sum(disk.pages) == 2100
    assert max(disk.pages) <= 250
    busy = 0.010 * len(disk.pages)
    assert disk.rested == pytest.approx(3.0 * (busy - 0.010))
    assert logs.readers == 0


async def test_of_many_readers_one_reads_at_a_time() -> None:
    logs, room, disk = opened(1000)
    await asyncio.gather(*(whole(logs, room, f"{n}") for n in range(20)))
    assert disk.most == 1
    assert logs.readers == 0


async def test_one_address_s_many_logs_do_not_delay_another_s() -> None:
    logs, room, disk = opened(2_000)

    async def read(reader: str, run: int) -> None:
        async for _ in await logs.read(room, reader, marks=False, run=run):
            pass

    several = [asyncio.create_task(read("several", 1)) for _ in range(MOST_OF_ONE)]
    await read("one", 2)
    assert disk.runs.count(2) == 8
    # `one` asks for its next page a turn later, so `several` read two pages for one of `one`.
    assert disk.runs.count(1) <= 2 * 8
    await asyncio.gather(*several)
    assert disk.runs.count(1) == 8 * MOST_OF_ONE


async def test_one_address_reads_few_logs_and_all_a_bounded_number() -> None:
    logs, room, _ = opened(1000)
    held = [await logs.read(room, "a", marks=False) for _ in range(MOST_OF_ONE)]
    with pytest.raises(ReadersError, match="your address"):
        await logs.read(room, "a", marks=False)
    for n in range(MOST_READERS - MOST_OF_ONE):
        held.append(await logs.read(room, f"b{n}", marks=False))
    with pytest.raises(BusyError):
        await logs.read(room, "c", marks=False)
    # A reader that leaves before the first piece was sent gives up its place, too.
    held.clear()
    gc.collect()
    assert logs.readers == 0
    assert await whole(logs, room, "a")


async def test_a_ledger_that_fails_ends_a_log_unfinished_with_one_line(
    caplog: pytest.LogCaptureFixture,
) -> None:
    logs, room, disk = opened(1_000)
    answer = StreamedAnswer(await logs.read(room, "reader", marks=False))
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)
        if len(sent) == 3:
            disk.broken = True

    await answer({"type": "http", "asgi": {"spec_version": "2.4"}}, connected, send)
    assert [message["type"] for message in sent] == [
        "http.response.start",
        *_BODY * (len(sent) - 1),
    ]
    assert all(message["more_body"] for message in sent[1:]), "nothing says that this is all"
    (line,) = caplog.records
    assert (line.getMessage(), line.exc_info) == ("answer cut short", None)
    assert vars(line)["why"] == "the disk is gone"


_BODY = ["http.response.body"]


async def connected() -> Any:
    """Receive from a client that stays connected: never returns."""
    await asyncio.Event().wait()
