"""Sends what targets have not heard, to each in order, until it says that it has.

A request that is not answered with 2xx is sent again, later each time and for as long as it takes:
a target hears of every event at least once. One that ended before the ledger knew that the target
has heard is sent again after the next start, so that a target goes by the events' ids.
"""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Final

import httpx

from app.errors import LedgerError
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import webhook_store
from app.rooms.records import Heard
from app.webhooks.events import body_of, event_of, signed
from app.webhooks.targets import Target
from engine.json_text import JsonObject

MOST_BOARDS: Final = 64  # whose labels are remembered from one request to the next
MOST: Final = 100  # events in a request
LOOK: Final = 0.2  # s between looks at what waits, where nothing did
FIRST, LONGEST = 1.0, 60.0  # s between tries: doubled from the first to the longest
PATIENCE: Final = 10.0  # s that a target has to answer

_log = logging.getLogger("plinko")


class Sender:
    """Sends to one target; for the event loop's thread.

    `mine` says whether it is this server that sends, where several share the ledger. `late` is for
    how many s the target has not taken what it was sent.
    """

    def __init__(
        self,
        target: Target,
        ledger: Ledger,
        http: httpx.AsyncClient,
        *,
        mine: Callable[[], bool] = lambda: True,
        now: Callable[[], float] = time.time,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        patience: float = PATIENCE,
    ) -> None:
        self.target = target
        self._ledger = ledger
        self._http = http
        self._mine = mine
        self._now = now
        self._sleep = sleep
        self._patience = patience
        self._failing_since: float | None = None
        self._labels: dict[str, webhook_store.Labels] = {}  # by board

    @property
    def late(self) -> float:
        """Seconds since the first try that failed, 0 once one has succeeded."""
        return 0.0 if self._failing_since is None else self._now() - self._failing_since

    async def run(self) -> None:
        """Send until cancelled."""
        while True:
            try:
                waited = self._mine() and await self._send_waiting()
            except LedgerError:  # which says so itself
                waited = False
            except Exception:  # noqa: BLE001 - one target must not end the others
                _log.exception(
                    "webhook %s: what waits cannot be sent; it is tried again", self.target.name
                )
                self._fail()
                await self._sleep(LONGEST)
                continue
            if not waited:
                await self._sleep(LOOK)

    async def _send_waiting(self) -> bool:
        """Send what waits, if anything does: a request of it. Raises LedgerError."""
        read = self._ledger.read
        rows = await read(webhook_store.waiting, target=self.target.url, most=MOST)
        if not rows:
            return False
        if len(self._labels) >= MOST_BOARDS:
            self._labels.clear()
        for board in {row["board"] for row in rows} - self._labels.keys():
            self._labels[board] = await read(webhook_store.labels, board=board)
        await self._deliver(rows)
        await self._ledger.commit(Heard(tuple(row["number"] for row in rows)))
        return True

    async def _deliver(self, rows: Sequence[JsonObject]) -> None:
        """Return once the target has taken these."""
        body = body_of([event_of(row, self._labels[row["board"]]) for row in rows])
        message = f"{rows[0]['number']}-{rows[-1]['number']}"
        delay = FIRST
        while (fault := await self._try(message, body)) is not None:
            if self._failing_since is None:
                _log.warning("webhook %s: %s; it is tried again", self.target.name, fault)
            self._fail()
            await self._sleep(delay)
            delay = min(2.0 * delay, LONGEST)
        if self._failing_since is not None:
            _log.warning("webhook %s takes events again", self.target.name)
            self._failing_since = None

    def _fail(self) -> None:
        if self._failing_since is None:
            self._failing_since = self._now()

    async def _try(self, message: str, body: bytes) -> str | None:
        """Send one request; returns why the target has not taken it, None if it has."""
        headers = signed(self.target.key, message, int(self._now()), body)
        try:
            async with (
                asyncio.timeout(self._patience),
                # Nothing of what it answers is read: it might not end.
                self._http.stream("POST", self.target.url, content=body, headers=headers) as answer,
            ):
                return None if answer.is_success else f"it answered {answer.status_code}"
        except (httpx.HTTPError, TimeoutError) as error:
            return str(error) or type(error).__name__
