"""The order in which rooms are rebuilt: those that clients wait for, then the rest, one by one."""

import asyncio
from collections import Counter, OrderedDict
from collections.abc import Awaitable, Callable, Iterable
from typing import Final

from app.concurrency.signal import Signal
from app.concurrency.single_flight import SingleFlight
from app.errors import DamagedRoomError, LedgerError, RebuildingError
from app.rooms.records import Parked

_WAIT_SECONDS: Final = 10.0  # how long a caller waits for a room before it gets an error
_REST: Final = 0.02  # s of pause after each slice of a room that no caller waits for
_RETRY: Final = 0.5  # s until the next attempt, after the ledger could not be read

Turn = Callable[[], Awaitable[None]]
"""Awaited between two slices of a rebuild; returns when the next slice may run."""


class RebuildQueue:
    """Rooms that were awake when the last server ended; for the event loop's thread.

    `rebuild` restores the room with an id. It raises DamagedRoomError for a room that is set aside,
    and LedgerError if the ledger cannot be read now. Rooms that callers wait for are rebuilt at
    once, and the background rebuild pauses meanwhile, so that it does not delay them.
    """

    def __init__(
        self,
        rebuild: Callable[[str, Turn], Awaitable[None]],
        *,
        patience: float = _WAIT_SECONDS,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._rebuild = rebuild
        self._patience = patience
        self._sleep = sleep
        self._waiting: OrderedDict[str, Parked] = OrderedDict()
        self._flights = SingleFlight[None]()
        self._asked: Counter[str] = Counter()
        self._asking = Signal()  # sent when `_asked` changes

    @property
    def waiting(self) -> list[Parked]:
        return list(self._waiting.values())

    def __contains__(self, room_id: str) -> bool:
        return room_id in self._waiting

    def fill(self, rooms: Iterable[Parked]) -> None:
        """Add rooms to rebuild, in this order."""
        self._waiting.update((room.id, room) for room in rooms)

    async def run(self) -> None:
        """Rebuild all rooms, one after another; when cancelled, cancels all rebuilds."""
        try:
            while self._waiting:
                try:
                    await self._bring(next(iter(self._waiting)))
                except DamagedRoomError:
                    continue  # it is set aside; a caller that needs it gets the reason
                except LedgerError:
                    await self._sleep(_RETRY)
        finally:
            await self._flights.cancel()

    async def need(self, room_id: str) -> None:
        """Return when the room is rebuilt; at once if it is not in this queue.

        Raises DamagedRoomError, LedgerError, and RebuildingError after `patience` seconds.
        """
        if room_id not in self._waiting:
            return
        self._ask(room_id, 1)
        try:
            async with asyncio.timeout(self._patience):
                await self._bring(room_id)
        except TimeoutError:
            raise rebuilding(room_id) from None
        finally:
            self._ask(room_id, -1)

    def _ask(self, room_id: str, change: int) -> None:
        """Count callers that begin (+1) or stop (-1) to wait for this room."""
        self._asked[room_id] += change
        if not self._asked[room_id]:
            del self._asked[room_id]
        self._asking.send()

    async def _bring(self, room_id: str) -> None:
        """Rebuild a room, once for all callers; raises what `rebuild` raises."""

        async def rebuild() -> None:
            try:
                await self._rebuild(room_id, lambda: self._turn(room_id))
            except DamagedRoomError:
                del self._waiting[room_id]
                raise
            del self._waiting[room_id]

        await self._flights.do(room_id, rebuild)

    async def _turn(self, room_id: str) -> None:
        if room_id in self._asked:
            return
        # No caller waits for this room, so leave half of the time to the rooms in play.
        await self._sleep(_REST)
        while self._asked and room_id not in self._asked:
            await self._asking.wait()


def rebuilding(room_id: str) -> RebuildingError:
    """The error for a caller that needs a room which is not yet rebuilt."""
    return RebuildingError(
        f"room {room_id!r} is being rebuilt from the ledger; it is not lost, try again soon",
        field="room",
    )
