"""While the ledger takes no writes, a room's log is sent complete or not at all."""

import asyncio
from pathlib import Path
from typing import Any

import msgspec
import pytest

from plinko.app.errors import LedgerError
from plinko.app.persistence.room_log import RoomLogs
from plinko.app.rooms.log import verify_log
from tests.app.persistence.ledger.stepped import Table, failure
from tests.kit.told import Told

ROOM = "triangle-8"


def refuse_writes(step: str) -> None:
    """Fail every write, as on a full disk; reads work."""
    if step.startswith("UPDATE writers"):  # the first statement of every batch
        raise failure()


def work(table: Table) -> None:
    for _ in range(5):
        table.turn()
        table.loop.deliver()


def log(table: Table) -> Any:
    """The room's log as a client receives it while writes fail, or the error raised."""

    async def read() -> bytes:
        live = await table.rooms.seek(ROOM)
        pieces = await RoomLogs(table.persistence.runs).read(live.room, "", marks=True)
        return b"".join([piece async for piece in pieces])

    asked = table.within(lambda: asyncio.ensure_future(read()))
    while not asked.done():  # the ledger reads between two attempts to write
        table.ledger.committer.turn()
        table.loop.deliver()
    return msgspec.json.decode(asked.result())


def test_a_log_does_not_lack_what_has_landed(tmp_path: Path) -> None:
    table = Table(f"sqlite:///{tmp_path / 'ledger.db'}", {ROOM: Told(ROOM)})
    try:
        table.until(table.rooms.seek(ROOM))
        table.asks(ROOM, 42)
        table.work()
        table.database.at = refuse_writes
        while table.tick(1):
            work(table)
        work(table)
        assert table.told[ROOM].landed
        assert not table.ledger.up
        with pytest.raises(LedgerError, match="disk I/O error"):
            assert verify_log(log(table)).ok
        table.database.at = lambda step: None
        table.work()
        whole = table.log(ROOM)
        assert verify_log(whole).ok
        assert whole["drops"][0]["result"] is not None
        table.database.at = refuse_writes
        refused = table.within(lambda: asyncio.ensure_future(table.ledger.commit()))
        work(table)
        assert isinstance(refused.exception(), LedgerError)
        assert log(table) == whole, "nothing of it is left to write"
    finally:
        table.end()
