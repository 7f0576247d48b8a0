"""The queue of a running room: drops the waiting balls at even intervals, a few at a time.

A new item is committed to the ledger before any client receives it. Each ball has a key, made of
its item and its number there. After a restart the room goes through an item from its first ball on;
the keys keep it from dropping a ball that the ledger already has.
"""

import asyncio
import functools
import logging
from collections.abc import Awaitable, Callable
from typing import Final

import msgspec

from plinko.app.errors import HaltedError, LedgerError, LimitError, ResetError, UndecidedError
from plinko.app.live.broadcast.audience import Player
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import store
from plinko.app.protocol import messages
from plinko.app.protocol.visitors import Tag
from plinko.app.rooms.keys import KeyUse, ball_key
from plinko.app.rooms.outcome import Outcome
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.queue import EMPTY, Item, Queue
from plinko.app.rooms.records import QueueRow

MOST_FALLING: Final = 20  # balls of a queue in flight at a time
_RETRY: Final = 1.0  # s until a ball that the room refused is tried again
_FAILED: Final = 30.0  # s until a retry after an unexpected error, so as not to flood the log
_SHOWN: Final = 5  # items listed in an event

_PASSING: Final = (HaltedError, LimitError, LedgerError, ResetError, UndecidedError)
"""Temporary errors: the queue waits and tries again."""

_log = logging.getLogger("plinko")


class RoomQueue:
    """The queue of room run `run`, for the event loop's thread.

    drop: drops a ball, unless the ledger has its key.
    flying: returns the balls in flight.
    landing: waits until a ball lands.
    draw: returns a random seed.
    tell: sends an event to all clients of the room.
    empty: the run is new, so that the ledger has no queue of it.
    """

    def __init__(
        self,
        ledger: Ledger,
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
        self._item = -1  # number of the item being dropped
        self._dropped = 0  # balls of it dropped until now

    @property
    def running(self) -> bool:
        """Whether the queue is dropping balls."""
        return self._task is not None and not self._task.done()

    @property
    def waiting(self) -> int:
        return sum(left for _, left in self.items)

    @property
    def items(self) -> list[tuple[Item, int]]:
        """The items with waiting balls, each with the number of those."""
        found = ((item, self._left(item)) for item in self.state.items)
        return [(item, left) for item, left in found if left]

    def _left(self, item: Item) -> int:
        return item.balls - (self._dropped if item.number == self._item else 0)

    @property
    def event(self) -> messages.QueueState:
        shown = [
            messages.QueueItem(number=item.number, left=left, **item.tag.fields)
            for item, left in self.items[:_SHOWN]
        ]
        return messages.QueueState(waiting=self.waiting, paused=self.state.paused, items=shown)

    async def load(self) -> None:
        """Read the queue from the ledger, once, and resume it; raises LedgerError."""
        if self._loaded:
            return
        async with self._turn:
            if not self._loaded:
                self.state = await self._ledger.read(store.queue, room=self._run)
                self._loaded = True
        self._go_on()

    async def add(self, balls: int, every: float, tag: Tag, use: KeyUse | None = None) -> None:
        """Queue more balls, if the `use` of the request's key is new.

        Raises BallLimitError, KeyReusedError, LedgerError.
        """
        step = functools.partial(Queue.with_item, balls=balls, every=every, tag=tag)
        await self._ledger.decided(self._change(step, use or KeyUse()))

    async def change(self, step: Callable[[Queue], Queue]) -> None:
        """Replace the queue by what `step` makes of it; raises LedgerError."""
        await self._ledger.decided(self._change(step, KeyUse()))

    async def _change(self, step: Callable[[Queue], Queue], use: KeyUse) -> None:
        await self.load()
        async with self._turn:
            if await self._ledger.look_up(use):  # a repeat needs no place in the queue
                return
            after = step(self.state)
            use.run, use.fact = self._run, str(self.state.next)
            row = QueueRow(self._run, msgspec.json.encode(after).decode())
            await self._ledger.commit(row, use=use)
            self.state = after
        self._tell_all(self.event)
        self._go_on()

    def end(self) -> None:
        """Stop dropping, because the room ends or leaves this server."""
        self._ended = True
        if self._task is not None:
            self._task.cancel()

    def _go_on(self) -> None:
        if self.state.items and not (self.state.paused or self.running or self._ended):
            self._task = asyncio.create_task(self._work(), name="queue")

    async def _work(self) -> None:
        """Drop the waiting balls one by one, until the queue is empty or paused."""
        falling: set[int] = set()
        while self.state.items and not self.state.paused:
            try:
                await self._take_step(falling)
            except _PASSING as error:
                _log.info("a queue waits and will retry: %s", error)
                await asyncio.sleep(_RETRY)
            except Exception:  # noqa: BLE001 - the queue retries after any error
                _log.exception("a queue failed to drop a ball and will retry")
                await asyncio.sleep(_FAILED)

    async def _take_step(self, falling: set[int]) -> None:
        """Drop the next ball, or wait for a landing if too many of the queue are `falling`."""
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
        key = ball_key(self._run, item.number, self._dropped)
        outcome = await self._drop(command, Player(idempotency_key=key))
        self._dropped += 1
        if outcome.landed is None:
            falling.add(outcome.accepted.ball)
        self._tell_all(self.event)
        if not outcome.earlier:
            await asyncio.sleep(item.every)
