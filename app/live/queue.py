"""The queue of one room while it is played in: drops what waits, evenly, a few balls at a time.

The ledger has what waits before anybody is told. Each ball has a key, made of its item and its
number there. After a restart the room goes through an item from its first ball on; the keys keep it
from dropping again what the ledger has.
"""

import asyncio
import functools
import logging
from collections.abc import Awaitable, Callable
from typing import Final

import msgspec

from app.errors import HaltedError, LedgerError, LimitError, ResetError, UndecidedError
from app.live.broadcast.audience import Player
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import queue_store, store
from app.protocol import messages
from app.protocol.visitors import Tag
from app.rooms.outcome import Outcome
from app.rooms.pending import DropCommand
from app.rooms.queue import EMPTY, Item, Queue, ball_key
from app.rooms.records import QueueRow

MOST_FALLING: Final = 20  # balls of a queue at a time
_RETRY: Final = 1.0  # s after which a ball is tried again that the room could not take
_FAILED: Final = 30.0  # s after an error that nobody expected, so that it does not fill the log
_SHOWN: Final = 5  # items that an event names

_PASSING: Final = (HaltedError, LimitError, LedgerError, ResetError, UndecidedError)
"""Errors that waiting helps against."""

_log = logging.getLogger("plinko")


class RoomQueue:
    """Of one run of a room, by its number; for the event loop's thread.

    `drop` takes a ball unless it was taken before, `flying` are the balls in flight, `landing`
    waits for the next one to land, `draw` gives a seed, and `tell` sends an event to all who watch.
    `empty`: the ledger has nothing of it.
    """

    def __init__(
        self,
        ledger: Ledger | NullLedger,
        run: int,
        *,
        drop: Callable[[DropCommand, Player], Awaitable[Outcome]],
        flying: Callable[[], set[int]],
        landing: Callable[[], Awaitable[None]],
        draw: Callable[[], int],
        tell: Callable[[messages.Event], None],
        empty: bool,
    ) -> None:
        self.state = EMPTY
        self._ledger = ledger
        self._run = run
        self._drop = drop
        self._flying = flying
        self._landing = landing
        self._draw = draw
        self._tell_all = tell
        self._loaded = empty
        self._turn = asyncio.Lock()
        self._task: asyncio.Task[None] | None = None
        self._ended = False
        self._item = -1  # number of the item that is being dropped
        self._dropped = 0  # its balls until now

    @property
    def running(self) -> bool:
        """Whether something is being dropped."""
        return self._task is not None and not self._task.done()

    @property
    def waiting(self) -> int:
        """Balls that wait."""
        return sum(left for _, left in self.items)

    @property
    def items(self) -> list[tuple[Item, int]]:
        """The items of which balls wait, with how many of them do."""
        found = ((item, self._left(item)) for item in self.state.items)
        return [(item, left) for item, left in found if left]

    def _left(self, item: Item) -> int:
        return item.balls - (self._dropped if item.number == self._item else 0)

    @property
    def event(self) -> messages.QueueState:
        """What those who watch are told."""
        shown = [
            messages.QueueItem(number=item.number, left=left, **item.tag.fields)
            for item, left in self.items[:_SHOWN]
        ]
        return messages.QueueState(waiting=self.waiting, paused=self.state.paused, items=shown)

    async def load(self) -> None:
        """Go on with what the ledger has of it; raises LedgerError."""
        if self._loaded:
            return
        async with self._turn:
            if not self._loaded:
                self.state = await self._ledger.read(queue_store.queue, room=self._run)
                self._loaded = True
        self._go_on()

    async def add(self, balls: int, every: float, tag: Tag, again: str | None = None) -> bool:
        """Have more balls wait; False where the same was asked for before, as `again` says.

        Raises BallLimitError, LedgerError.
        """
        step = functools.partial(Queue.with_item, balls=balls, every=every, tag=tag, again=again)
        return await self._ledger.decided(self._change(step, again))

    async def change(self, step: Callable[[Queue], Queue]) -> None:
        """Have what waits become what `step` makes of it; raises LedgerError."""
        await self._ledger.decided(self._change(step))

    async def _change(self, step: Callable[[Queue], Queue], again: str | None = None) -> bool:
        await self.load()
        async with self._turn:
            if again is not None and await self._has_been_asked(again):
                return False
            after = step(self.state)
            await self._ledger.commit(QueueRow(self._run, msgspec.json.encode(after).decode()))
            self.state = after
        self._tell_all(self.event)
        self._go_on()
        return True

    async def _has_been_asked(self, again: str) -> bool:
        """Whether there is an item by this key, or was: it goes once its balls are dropped."""
        if any(item.again == again for item in self.state.items):
            return True
        first = ball_key(again, 0)
        return await self._ledger.read(store.keyed, room=self._run, key=first) is not None

    def end(self) -> None:
        """The room ends or leaves: nothing more is dropped here."""
        self._ended = True
        if self._task is not None:
            self._task.cancel()

    def _go_on(self) -> None:
        if self.state.items and not (self.state.paused or self.running or self._ended):
            self._task = asyncio.create_task(self._work(), name="queue")

    async def _work(self) -> None:
        """Drop what waits, ball by ball, until nothing does or it is paused."""
        falling: set[int] = set()
        while self.state.items and not self.state.paused:
            try:
                await self._take_step(falling)
            except _PASSING as error:
                _log.info("a queue waits: %s", error)
                await asyncio.sleep(_RETRY)
            except Exception:  # noqa: BLE001 - whatever it is, it is tried again
                _log.exception("a queue failed at a ball, and tries it again")
                await asyncio.sleep(_FAILED)

    async def _take_step(self, falling: set[int]) -> None:
        """Drop the next ball, once there is room for it among those that are `falling`."""
        item = self.state.items[0]
        if item.number != self._item:
            self._item, self._dropped = item.number, 0
        if self._dropped == item.balls:
            await self.change(functools.partial(Queue.without, number=item.number))
            return
        falling &= self._flying()
        if len(falling) >= MOST_FALLING:
            await self._landing()
            return
        command = DropCommand(self._draw(), tag=item.tag)
        outcome = await self._drop(command, Player(again=item.key(self._dropped)))
        self._dropped += 1
        if outcome.landed is None:
            falling.add(outcome.accepted.ball)
        self._tell_all(self.event)
        if not outcome.earlier:
            await asyncio.sleep(item.every)
