"""Work that is done once for all callers that ask for it while it lasts."""

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(slots=True, eq=False)
class _Flight(Generic[T]):
    """Work that goes on, and how many callers wait for it."""

    task: asyncio.Task[T]
    callers: int = 0


class SingleFlight(Generic[T]):
    """For the event loop's thread.

    A caller that is cancelled takes the result from nobody else. With `abandons` the work is
    cancelled when its last caller is; without, it goes on to its end.
    """

    def __init__(self, *, abandons: bool = False) -> None:
        self._abandons = abandons
        self._flights: dict[str, _Flight[T]] = {}

    async def do(self, key: str, work: Callable[[], Coroutine[None, None, T]]) -> T:
        """The result of this key's work that goes on, or of `work`; raises what it raises."""
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
                self._end(key, flight)  # who asks from now on begins again

    async def cancel(self) -> None:
        """Cancel all that goes on, and wait until it has ended."""
        tasks = [flight.task for flight in self._flights.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _begin(self, key: str, work: Callable[[], Coroutine[None, None, T]]) -> _Flight[T]:
        flight = self._flights[key] = _Flight(asyncio.create_task(work(), name=key))

        def ended(task: asyncio.Task[T]) -> None:
            self._end(key, flight)
            if not task.cancelled():
                task.exception()  # every caller was told, or has left

        flight.task.add_done_callback(ended)
        return flight

    def _end(self, key: str, flight: _Flight[T]) -> None:
        if self._flights.get(key) is flight:
            del self._flights[key]
