"""Drops that take less than to be handed to a worker: the server's own process computes them.

The event loop waits for one meanwhile, and so does a tick. Few begin in a turn of the loop
(`app.web.edge.intake`), and what one may compute has a limit.
"""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from app.computing.process import Done
from engine import Board
from engine.drops import trajectory
from engine.errors import EngineError
from engine.jit.limits import at_most

EFFORT: Final = 4_000_000
"""Instructions of WebAssembly that a drop may take here, some 0.6 ms: 40 times what it mostly does
on a preset."""


class ShortDrops:
    """Drops on presets, for the event loop's thread; effort: of one, where calls are limited."""

    def __init__(self, effort: int = EFFORT) -> None:
        self._effort = effort
        self._preparing: dict[str, asyncio.Future[None]] = {}

    def is_ready(self, preset: Board) -> bool:
        """Whether a drop on this preset takes no longer than any other; else it soon will be.

        What drops on a board need takes some ms to make. A thread does it, once.
        """
        made = self._preparing.get(preset.digest)
        if made is None:
            loop = asyncio.get_running_loop()
            made = loop.run_in_executor(None, trajectory.prepare, preset)
            self._preparing[preset.digest] = made
        return made.done()

    def measured(self, work: Callable[[], object]) -> Done:
        """What came of `work`, which computes a drop on a ready preset, and how long it took.

        Its error is an EffortError where the drop takes more than it may here.
        """
        value: object = None
        error: Exception | None = None
        began = time.thread_time()
        try:
            with at_most(self._effort):
                value = work()
        except EngineError as raised:
            error = raised
        return Done(value, error, time.thread_time() - began)
