"""A ledger that stores nothing, for rooms without a database: every write succeeds at once.

It has no keys, so it finds no repeated request.
"""

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Final, TypeVar

from plinko.app.errors import LedgerError
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.ledger.commit_queue import Done
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import lease_store, store
from plinko.app.rooms.keys import KeyUse, UsedKey
from plinko.app.rooms.records import DropRow, NewDrop, NewInput, Write

T = TypeVar("T")

_ANSWERS: Final[dict[Callable[..., object], object]] = {
    lease_store.standing: (False, None),
    store.open_room: None,
    store.count_owned: 0,
    store.directory: [],
    store.unused_rooms: [],
}


class NullLedger(Ledger):
    """Has no room, and no thread."""

    lag = 0.0
    up = True

    def __init__(self) -> None:
        self.leases = LeaseBook()
        self._last: dict[int, tuple[int, int]] = {}  # number and tick of each run's last input

    def submit(self, *writes: Write, use: KeyUse | None = None) -> "asyncio.Future[None]":
        for write in writes:
            if isinstance(write, NewInput):
                write.number, _ = self._follow(write.room, write.tick)
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        future.set_result(None)
        return future

    async def drop(self, request: NewDrop, *before: Write) -> NewDrop:
        ball, tick = self._follow(request.room, request.tick)
        request.fact = DropRow.of(request.room, ball, tick, request.command)
        return request

    def _follow(self, run: int, tick: int) -> tuple[int, int]:
        """The number and the tick of a run's next input."""
        number, before = self._last.get(run, (-1, 0))
        self._last[run] = number + 1, max(before, tick)
        return self._last[run]

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        if done is not None:
            done(None)

    async def commit(self, *writes: Write, use: KeyUse | None = None) -> None:
        pass

    async def look_up(self, use: KeyUse) -> UsedKey | None:
        return None

    async def keep(self, *writes: Write) -> None:
        pass

    async def settled(self) -> None:
        pass

    async def decided(self, work: "Coroutine[None, None, T] | asyncio.Future[T]") -> T:
        return await asyncio.shield(work)

    async def read(self, read: Any, *args: Any, **values: Any) -> Any:
        asked = values.get("find", args[0] if args else read)
        if asked not in _ANSWERS:
            raise LedgerError("this server keeps no ledger")
        return _ANSWERS[asked]
