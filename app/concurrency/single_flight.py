"""Single flight: callers that ask for the same work while it runs share one run."""

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


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

    async def cancel(self) -> None:
        """Cancel all running work, and wait until it has ended."""
        tasks = [flight.task for flight in self._flights.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

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
