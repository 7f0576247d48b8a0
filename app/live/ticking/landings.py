"""Waits until a ball of a room lands, for requests that want a drop's result."""

import asyncio

from plinko.app.concurrency.signal import Signal
from plinko.app.errors import AppError
from plinko.app.protocol import messages


class Landings:
    """The waits of one room, by ball; for the event loop's thread."""

    def __init__(self) -> None:
        self._waiting: dict[int, list[asyncio.Future[messages.Landed | None]]] = {}
        self._any = Signal()

    @property
    def waiting(self) -> int:
        return len(self._waiting)

    async def wait(self, ball: int, seconds: float) -> messages.Landed | None:
        """Wait until the ball lands; returns None if that takes longer than `seconds`.

        Raises the error given to `end`.
        """
        future: asyncio.Future[messages.Landed | None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(ball, []).append(future)
        try:
            return await asyncio.wait_for(future, seconds)
        except TimeoutError:
            return None
        finally:
            waiting = self._waiting.get(ball, [])
            if future in waiting:
                waiting.remove(future)
            if not waiting:
                self._waiting.pop(ball, None)

    async def next(self) -> None:
        """Wait until any ball lands."""
        await self._any.wait()

    def landed(self, landed: messages.Landed) -> None:
        self._any.send()
        for future in self._waiting.pop(landed.ball, ()):
            if not future.done():
                future.set_result(landed)

    def end(self, error: AppError) -> None:
        for future in self._all():
            future.set_exception(error)

    def leave(self) -> None:
        """End all waits as if they had timed out: the balls land at another server, or later."""
        for future in self._all():
            future.set_result(None)

    def _all(self) -> list["asyncio.Future[messages.Landed | None]"]:
        found = [each for futures in self._waiting.values() for each in futures if not each.done()]
        self._waiting.clear()
        return found
