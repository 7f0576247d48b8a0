"""Numbers of sessions where several servers share the ledger: taken from it a block at a time."""

import asyncio
import logging
from collections import deque
from typing import Final

from app.errors import LedgerError
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import lease_store

_BLOCK: Final = 1024
_LOW: Final = _BLOCK // 2  # numbers left, at which more are asked for

_log = logging.getLogger("plinko")


class SharedNumbers:
    """For the event loop's thread, which waits for none of it but the first block."""

    def __init__(self, ledger: Ledger | NullLedger) -> None:
        self._ledger = ledger
        self._left: deque[int] = deque()
        self._filling: asyncio.Task[None] | None = None

    async def fill(self) -> None:
        """Have a block more; raises LedgerError."""
        first = await self._ledger.read(lease_store.reserve, count=_BLOCK)
        self._left.extend(range(first, first + _BLOCK))

    def next(self) -> int:
        """A number that no session has had; raises LedgerError when none is at hand."""
        if len(self._left) <= _LOW and self._filling is None:
            self._filling = asyncio.create_task(self._refill(), name="numbers")
        if not self._left:
            raise LedgerError("no number for a session is at hand before the ledger answers")
        return self._left.popleft()

    async def _refill(self) -> None:
        try:
            await self.fill()
        except LedgerError as error:
            _log.warning("no numbers for sessions: %s", error)  # the next one asks again
        finally:
            self._filling = None
