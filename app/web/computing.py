"""All that computes and draws for requests, and what each address pays for it."""

import asyncio
import functools
import time
from collections.abc import Callable
from typing import Final, TypeVar, TypeVarTuple, cast

from plinko.app.computing.pool import MAX_JOBS, Workers
from plinko.app.computing.prices import Price
from plinko.app.computing.process import Done
from plinko.app.errors import EndedError
from plinko.app.persistence.room_log import MOST_READERS
from plinko.app.pictures.cache import PICTURE_BYTES, Pictures
from plinko.app.pictures.film import MAX_CAMERAS, MAX_VIEWERS, Cameras
from plinko.app.web.limits import COMPUTE_BURST, COMPUTE_RATE, Budgets
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


T = TypeVar("T")
Ts = TypeVarTuple("Ts")

_MOMENTS: Final = 1 << 22
"""Bytes of cached room frames, for clients that ask at the same moment."""


class Computing:
    """Workers, short drops, caches of pictures and cameras. `readers` only reads the ledger."""

    def __init__(self, processes: int) -> None:
        self.budgets = Budgets(COMPUTE_RATE, COMPUTE_BURST)
        self.workers = Workers(processes, MAX_JOBS)
        self.readers = Workers(1, MOST_READERS)
        self.short = ShortDrops()
        self.pictures = Pictures(PICTURE_BYTES)
        self.moments = Pictures(_MOMENTS)
        self.cameras = Cameras(MAX_CAMERAS, MAX_VIEWERS, budget=self.budgets)

    def is_short(self, price: Price) -> bool:
        """Whether `at_once` can do a job of this price now."""
        return price.preset is not None and self.short.is_ready(price.preset)

    def at_once(self, address: str, price: Price, task: Callable[[*Ts], T], *values: *Ts) -> T:
        """The result of `task(*values)`, a short drop, computed by this process.

        Raises BudgetError, EffortError if it is no short drop, and the errors of the task.
        """
        now = time.monotonic()
        self.budgets.charge(address, now, price.seconds, price.what)
        done = self.short.measured(functools.partial(task, *values))
        self.budgets.settle(address, now, done.seconds - price.seconds)
        return cast(T, _result(done))

    async def compute(
        self, address: str, price: Price, task: Callable[[*Ts], T], *values: *Ts
    ) -> T:
        """The result of `task(*values)`, computed by a worker and charged to the address.

        Raises CostError for a price over its limit, BudgetError, BusyError, and the errors of the
        task.
        """
        price.check()
        self.budgets.charge(address, time.monotonic(), price.seconds, price.what)
        spent: list[float] = []
        try:
            work = functools.partial(task, *values)
            done = await self.workers.measured(work, quick=price.quick, spend=spent.append)
        except EndedError:  # nobody knows what it took
            spent.append(price.seconds)
            raise
        finally:
            self.budgets.settle(address, time.monotonic(), sum(spent) - price.seconds)
        return cast(T, _result(done))

    def release(self) -> None:
        """End all work, so that the requests that wait for it are answered."""
        self.workers.close()
        self.readers.close()

    def close(self) -> None:
        self.cameras.close()
        self.release()


def _result(done: Done) -> object:
    if done.error is not None:
        raise done.error
    return done.value
