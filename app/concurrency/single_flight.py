"""How tasks share work: callers that ask for the same work while it runs share one run.

SingleFlight is that; a Signal wakes all who wait; `to_the_end` lets work outlive its caller.
"""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Generic, TypeVar

from plinko.app.errors import LeaseLostError

T = TypeVar("T")

_log = logging.getLogger("plinko")


@dataclass(slots=True, eq=False)
class _Flight(Generic[T]):
    """Running work, and the number of callers that wait for it."""

    task: asyncio.Task[T]
    callers: int = 0


class SingleFlight(Generic[T]):
    """For the event loop's thread.

    Cancelling one caller does not affect the others. When the last caller is cancelled, the work
    is cancelled too if `abandons` is set; otherwise it runs until it is done.
    """

    def __init__(self, *, abandons: bool = False) -> None:
        self._abandons = abandons
        self._flights: dict[str, _Flight[T]] = {}

    async def do(self, key: str, work: Callable[[], Coroutine[None, None, T]]) -> T:
        """Join the work that runs under this key, or start `work`; returns or raises its result."""
        flight = self._flights.get(key)
        if flight is None:
            flight = self._begin(key, work)
        flight.callers += 1
        try:
            return await asyncio.shield(flight.task)
        finally:
            flight.callers -= 1
            if self._abandons and not flight.callers and not flight.task.done():
                flight.task.cancel()
                self._end(key, flight)  # later callers start the work again

    def _begin(self, key: str, work: Callable[[], Coroutine[None, None, T]]) -> _Flight[T]:
        flight = self._flights[key] = _Flight(asyncio.create_task(work(), name=key))

        def ended(task: asyncio.Task[T]) -> None:
            self._end(key, flight)
            if not task.cancelled():
                # Each caller has received the error or has left. Marking it as retrieved keeps
                # asyncio from logging it again.
                task.exception()

        flight.task.add_done_callback(ended)
        return flight

    def _end(self, key: str, flight: _Flight[T]) -> None:
        if self._flights.get(key) is flight:
            del self._flights[key]


class Signal:
    """For the event loop's thread. Unlike an Event, it never stays set and needs no clearing."""

    def __init__(self) -> None:
        self._next = asyncio.Event()

    def send(self) -> None:
        """Wake all tasks that wait now."""
        sent, self._next = self._next, asyncio.Event()
        sent.set()

    async def wait(self) -> None:
        await self._next.wait()


async def to_the_end(work: Coroutine[None, None, T]) -> T:
    """Await `work`; if the caller is cancelled, `work` still runs until it is done.

    Work that writes to the ledger and then updates memory must not stop between the two, or they
    would differ.
    """
    running = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(running)
    except asyncio.CancelledError:
        running.add_done_callback(log_failure)
        raise


def log_failure(done: "asyncio.Future[T]") -> None:
    """Log the failure of work whose caller has left.

    A LeaseLostError is not logged here: it is logged once for its room.
    """
    if done.cancelled() or (error := done.exception()) is None:
        return
    if not isinstance(error, LeaseLostError):
        _log.warning("work failed after its caller had left: %s", error)
