"""Who waits for a ball to land, and is told when it has, or why it never will."""

import asyncio

from app.errors import AppError
from app.protocol import messages
from app.rooms.room import Room


class Landings:
    """Waits by room and ball; for the event loop's thread."""

    def __init__(self) -> None:
        self._waiting: dict[tuple[str, int], list[asyncio.Future[messages.Landed | None]]] = {}

    @property
    def waiting(self) -> int:
        """How many balls are waited for."""
        return len(self._waiting)

    async def wait(self, room: Room, ball: int, seconds: float) -> messages.Landed | None:
        """Wait until the ball in flight lands; None when that takes longer than `seconds`.

        Raises the error with which the room's waits are ended.
        """
        loop = asyncio.get_running_loop()
        future: asyncio.Future[messages.Landed | None] = loop.create_future()
        key = (room.id, ball)
        self._waiting.setdefault(key, []).append(future)
        try:
            return await asyncio.wait_for(future, seconds)
        except TimeoutError:
            return None
        finally:
            waiting = self._waiting.get(key, [])
            if future in waiting:
                waiting.remove(future)
            if not waiting:
                self._waiting.pop(key, None)

    def landed(self, room: Room, landed: messages.Landed) -> None:
        """A ball has landed."""
        for future in self._waiting.pop((room.id, landed.ball), ()):
            if not future.done():
                future.set_result(landed)

    def end(self, room: Room, error: AppError) -> None:
        """Nothing of this room will land any more."""
        for key in [key for key in self._waiting if key[0] == room.id]:
            for future in self._waiting.pop(key):
                if not future.done():
                    future.set_exception(error)

    def leave(self, room_id: str) -> None:
        """The room goes on at another server: who waits is told that it takes too long."""
        for key in [key for key in self._waiting if key[0] == room_id]:
            for future in self._waiting.pop(key):
                if not future.done():
                    future.set_result(None)

    def stop(self) -> None:
        """The server stops: who waits is told that it takes too long."""
        for futures in self._waiting.values():
            for future in futures:
                if not future.done():
                    future.set_result(None)
