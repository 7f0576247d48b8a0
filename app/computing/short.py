"""Drops that take less than to be handed to a worker: the server's own process computes them.

One at a time, and after each the event loop does what else is due. So a tick waits for one of them
at most, however many clients ask at once.
"""

import asyncio
import functools
import time
from collections.abc import Callable
from typing import Any, Final

from app.computing.process import Done
from app.concurrency.fair_queue import FairLock
from app.concurrency.single_flight import SingleFlight
from engine import Board
from engine.drops import trajectory
from engine.errors import EngineError
from engine.jit.limits import at_most

EFFORT: Final = 4_000_000
"""Instructions of WebAssembly that a drop may take here, some 0.6 ms: 40 times what it mostly does
on a preset."""


class ShortWork:
    """Clients have their turns one after the other; for the event loop's thread.

    effort: of one drop, where calls of kernels are limited.
    """

    def __init__(self, effort: int = EFFORT) -> None:
        self.seconds = 0.0  # computed until now
        self._effort = effort
        self._turns = FairLock()
        self._prepared: set[str] = set()
        self._preparing = SingleFlight[None]()

    async def measured(self, client: str, preset: Board, work: Callable[[], Any]) -> Done:
        """What came of `work`, which computes a drop on this preset, and how long it took.

        Its error is an EffortError where the drop takes more than it may here.
        """
        if preset.digest not in self._prepared:
            make = functools.partial(asyncio.to_thread, trajectory.prepare, preset)
            await self._preparing.do(preset.digest, make)
            self._prepared.add(preset.digest)
        async with self._turns.turn(client):
            done = self._done(work)
            await asyncio.sleep(0)
        self.seconds += done.seconds
        return done

    def _done(self, work: Callable[[], Any]) -> Done:
        value: Any = None
        error: Exception | None = None
        began = time.thread_time()
        try:
            with at_most(self._effort):
                value = work()
        except EngineError as raised:
            error = raised
        return Done(value, error, time.thread_time() - began)
