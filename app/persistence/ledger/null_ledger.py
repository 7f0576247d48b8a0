"""A ledger that stores nothing, for rooms without a database: every write succeeds at once."""

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import NoReturn, TypeVar

from app.errors import LedgerError
from app.persistence.ledger.commit_queue import Done
from app.rooms.records import Write

T = TypeVar("T")


class NullLedger:
    """The null object for `Ledger`, with the methods that rooms use."""

    keeps = False
    lag = 0.0
    up = True

    def submit(self, *writes: Write, line: int | None = None) -> "asyncio.Future[None]":
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        future.set_result(None)
        return future

    def reopen(self, line: int) -> None:
        pass

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        if done is not None:
            done(None)

    async def commit(self, *writes: Write) -> None:
        pass

    async def keep(self, *writes: Write) -> None:
        pass

    async def settled(self) -> None:
        pass

    async def decided(self, work: "Coroutine[None, None, T] | asyncio.Future[T]") -> T:
        return await asyncio.shield(work)

    async def read(self, read: Callable[..., object], *args: object, **values: object) -> NoReturn:
        raise LedgerError("this server keeps no ledger")
