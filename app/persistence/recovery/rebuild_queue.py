"""Which room comes back from the ledger next: one that is asked for, else the rest, by and by."""

import asyncio
from collections import Counter, OrderedDict
from collections.abc import Awaitable, Callable, Iterable
from typing import Final

from app.concurrency.signal import Signal
from app.concurrency.single_flight import SingleFlight
from app.errors import DamagedRoomError, LedgerError, RebuildingError
from app.rooms.records import Parked

_PATIENCE: Final = 10.0  # s that someone waits for a room before hearing that it takes longer
_REST: Final = 0.02  # s of rest after each slice of a room that nobody waits for
_RETRY: Final = 0.5  # s until the ledger is asked again that could not be read

Turn = Callable[[], Awaitable[None]]
"""Awaited between slices of a rebuild; returns when the next slice may be run."""


class RebuildQueue:
    """Rooms that moved when the last server ended; for the event loop's thread.

    `rebuild` brings the room of this id back; it raises DamagedRoomError for one that is set aside,
    LedgerError when the ledger cannot be read now. Those that are asked for are rebuilt at once,
    and the others wait meanwhile, so that none of them holds up who came first.
    """

    def __init__(
        self,
        rebuild: Callable[[str, Turn], Awaitable[None]],
        *,
        patience: float = _PATIENCE,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._rebuild = rebuild
        self._patience = patience
        self._sleep = sleep
        self._waiting: OrderedDict[str, Parked] = OrderedDict()
        self._flights = SingleFlight[None]()
        self._asked: Counter[str] = Counter()
        self._asking = Signal()  # `_asked` has changed

    @property
    def waiting(self) -> list[Parked]:
        return list(self._waiting.values())

    def __contains__(self, room_id: str) -> bool:
        return room_id in self._waiting

    def fill(self, rooms: Iterable[Parked]) -> None:
        """These are to come back, in this order."""
        self._waiting.update((room.id, room) for room in rooms)

    async def run(self) -> None:
        """Bring all of them back, one after another; ends all that it began when cancelled."""
        try:
            while self._waiting:
                try:
                    await self._bring(next(iter(self._waiting)))
                except DamagedRoomError:
                    continue  # it is set aside; a caller that needs it is told why
                except LedgerError:
                    await self._sleep(_RETRY)
        finally:
            await self._flights.cancel()

    async def need(self, room_id: str) -> None:
        """Return once the room is back, or never was to come.

        Raises DamagedRoomError, LedgerError, and RebuildingError when it takes too long to wait.
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
        """So many more wait for this room."""
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
        # What nobody waits for leaves half of the time to those who play.
        await self._sleep(_REST)
        while self._asked and room_id not in self._asked:
            await self._asking.wait()


def rebuilding(room_id: str) -> RebuildingError:
    """The answer to who asks for a room that is not back yet."""
    return RebuildingError(
        f"room {room_id!r} is being rebuilt from the ledger; it is not lost", field="room"
    )
