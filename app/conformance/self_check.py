"""The server checks that its files are unchanged: at its start, once a day, and on request."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final

from plinko.app.conformance.inventory import Digests
from plinko.engine.json_text import Json

DAY: Final = 86400.0  # s
_FRESH: Final = 1.0  # s for which a finding is reused, because reading all files is expensive

_log = logging.getLogger("plinko")


@dataclass(frozen=True, slots=True)
class Finding:
    """The digests at the start and now; `at` is the Unix time in s."""

    started_with: Digests
    found: Digests
    at: float

    @property
    def same(self) -> bool:
        """Whether nothing has changed since the start."""
        return self.found == self.started_with

    def to_dict(self) -> dict[str, Json]:
        return {
            **self.found.to_dict(),
            "at": self.at,
            "at_start": self.started_with.whole,
            "unchanged": self.same,
        }


class SelfCheck:
    """Checks on the event loop. `look` reads all files, in a thread; `now` gives Unix time in s."""

    def __init__(
        self,
        look: Callable[[], Digests],
        *,
        now: Callable[[], float] = time.time,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self.last: Finding | None = None
        self._look = look
        self._now = now
        self._sleep = sleep
        self._turn = asyncio.Lock()

    @property
    def sound(self) -> bool:
        """Whether the last check found the digests of the start."""
        return self.last is None or self.last.same

    async def run(self) -> None:
        """Check now and then once a day, until cancelled."""
        while True:
            try:
                found = await self.look()
                _log.info("integrity", extra={"digest": found.found.whole})
            except OSError as error:
                _log.error("the program's files cannot be read: %s", error)
            await self._sleep(DAY)

    async def look(self) -> Finding:
        """Check the files now; raises OSError if one cannot be read."""
        async with self._turn:
            last = self.last
            if last is not None and 0.0 <= self._now() - last.at < _FRESH:
                return last
            found = await asyncio.to_thread(self._look)
            first = found if last is None else last.started_with
            self.last = Finding(first, found, self._now())
            if not self.last.same and (last is None or last.same):
                _log.error(
                    "the program's files have changed since the start: %s, not %s",
                    found.whole,
                    first.whole,
                )
            return self.last
