"""Who waits for a ball of a room to land, and is told when it has, or why it never will."""

import asyncio

from app.concurrency.signal import Signal
from app.errors import AppError
from app.protocol import messages


class Landings:
    """Waits by ball; for the event loop's thread."""

    def __init__(self) -> None:
        self._waiting: dict[int, list[asyncio.Future[messages.Landed | None]]] = {}
        self._any = Signal()

    @property
    def waiting(self) -> int:
        return len(self._waiting)

    async def wait(self, ball: int, seconds: float) -> messages.Landed | None:
        """Wait until the ball in flight lands; None when that takes longer than `seconds`.

        Raises the error with which the room's waits are ended.
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
        """Wait until a ball lands, whichever."""
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
        """The balls land elsewhere, or after this server: who waits is told it takes too long."""
        for future in self._all():
            future.set_result(None)

    def _all(self) -> list["asyncio.Future[messages.Landed | None]"]:
        found = [each for futures in self._waiting.values() for each in futures if not each.done()]
        self._waiting.clear()
        return found
