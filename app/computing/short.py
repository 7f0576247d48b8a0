"""Compute cheap drops on the event loop: faster than handing them to a worker.

The event loop, and with it every tick, waits for such a drop. Therefore its effort is limited, and
`plinko.app.web.edge.intake` lets few requests begin in each iteration of the loop.
"""

import asyncio
import time
from collections.abc import Callable
from typing import Final

from plinko.app.computing.process import Done
from plinko.engine import Board
from plinko.engine.drops import trajectory
from plinko.engine.errors import EngineError
from plinko.engine.jit.limits import at_most

EFFORT: Final = 4_000_000
"""WebAssembly instructions that a drop may take here, about 0.6 ms: 40 times the usual number on a
preset."""


class ShortDrops:
    """Drops on presets, in the event loop's thread; `effort` limits each, in instructions."""

    def __init__(self, effort: int = EFFORT) -> None:
        self._effort = effort
        self._preparing: dict[str, asyncio.Future[None]] = {}

    def is_ready(self, preset: Board) -> bool:
        """Whether the board's arrays are ready, so that a drop takes no longer than usual.

        Making them takes some ms. The first call for a board has a thread do it.
        """
        made = self._preparing.get(preset.digest)
        if made is None:
            loop = asyncio.get_running_loop()
            made = loop.run_in_executor(None, trajectory.prepare, preset)
            self._preparing[preset.digest] = made
        return made.done()

    def measured(self, work: Callable[[], object]) -> Done:
        """Run `work`, which computes a drop on a ready preset.

        The error of the result is an EffortError if the drop exceeds the effort.
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
