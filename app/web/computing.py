"""All that computes and draws for requests, and what each address pays for it."""

import asyncio
import functools
import time
from collections.abc import Callable
from typing import Final, TypeVar, TypeVarTuple, cast

from plinko.app.computing.pool import MAX_JOBS, Workers
from plinko.app.computing.prices import Price
from plinko.app.errors import EndedError
from plinko.app.persistence.room_log import MOST_READERS
from plinko.app.pictures.cache import PICTURE_BYTES, Pictures
from plinko.app.pictures.film import MAX_CAMERAS, MAX_VIEWERS, Cameras
from plinko.app.web.limits import COMPUTE_BURST, COMPUTE_RATE, Budgets
from plinko.engine.drops import trajectory
from plinko.engine.jit.limits import at_most

EFFORT: Final = 4_000_000
"""WebAssembly instructions that a drop may take here, about 0.6 ms: 40 times the usual number on a
preset."""

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

_MOMENTS: Final = 1 << 22
"""Bytes of cached room frames, for clients that ask at the same moment."""


class Computing:
    """Workers, caches of pictures, and cameras. `readers` only reads the ledger."""

    def __init__(self, processes: int) -> None:
        self.budgets = Budgets(COMPUTE_RATE, COMPUTE_BURST)
        self.workers = Workers(processes, MAX_JOBS)
        self.readers = Workers(1, MOST_READERS)
        self.effort = EFFORT
        self._preparing: dict[str, asyncio.Future[None]] = {}
        self.pictures = Pictures(PICTURE_BYTES)
        self.moments = Pictures(_MOMENTS)
        self.cameras = Cameras(MAX_CAMERAS, MAX_VIEWERS, budget=self.budgets)

    def is_short(self, price: Price) -> bool:
        """Whether `at_once` can do a job of this price now: a drop on a preset that is ready.

        Making a preset's arrays takes some ms. The first call for a preset has a thread do it.
        """
        if price.preset is None:
            return False
        made = self._preparing.get(price.preset.digest)
        if made is None:
            loop = asyncio.get_running_loop()
            made = loop.run_in_executor(None, trajectory.prepare, price.preset)
            self._preparing[price.preset.digest] = made
        return made.done()

    def at_once(self, address: str, price: Price, task: Callable[[*Ts], T], *values: *Ts) -> T:
        """The result of `task(*values)`, a short drop, computed by the event loop's thread.

        Raises BudgetError, EffortError if it takes more than `effort` instructions, and the errors
        of the task.
        """
        now = time.monotonic()
        self.budgets.charge(address, now, price.seconds, price.what)
        began = time.thread_time()
        try:
            return at_most(self.effort, task, *values)
        finally:
            self.budgets.settle(address, now, time.thread_time() - began - price.seconds)

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
        if done.error is not None:
            raise done.error
        return cast(T, done.value)

    def release(self) -> None:
        """End all work, so that the requests that wait for it are answered."""
        self.workers.close()
        self.readers.close()

    def close(self) -> None:
        self.cameras.close()
        self.release()
