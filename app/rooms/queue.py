"""A room's queue of balls to drop: items of several balls each, for one player. Pure."""

from typing import Final

import msgspec

from plinko.app.errors import BallLimitError
from plinko.app.protocol.visitors import NO_TAG, Tag

MOST_ITEMS: Final = 100
MOST_BALLS: Final = 1000  # of one item
MOST_WAITING: Final = 5000  # balls of all items


class Item(msgspec.Struct, frozen=True, omit_defaults=True):
    """Balls to drop, one every `every` seconds; `number` identifies the item in its room run."""

    number: int
    balls: int
    every: float
    tag: Tag = NO_TAG


class Queue(msgspec.Struct, frozen=True, omit_defaults=True):
    """The items in order. Unless the queue is `paused`, the first one is being dropped."""

    items: tuple[Item, ...] = ()
    paused: bool = False
    next: int = 0

    def with_item(self, balls: int, every: float, tag: Tag) -> "Queue":
        """The queue with another item at its end; raises BallLimitError if the queue is full."""
        if len(self.items) >= MOST_ITEMS:
            raise BallLimitError(f"the queue already has {MOST_ITEMS} items, the limit")
        waiting = sum(item.balls for item in self.items)
        if waiting + balls > MOST_WAITING:
            raise BallLimitError(
                f"n {balls}: {waiting} balls wait already, and at most {MOST_WAITING} may wait",
                field="n",
            )
        item = Item(self.next, balls, every, tag)
        return Queue((*self.items, item), self.paused, self.next + 1)

    def without(self, number: int) -> "Queue":
        return self._of(tuple(item for item in self.items if item.number != number))

    def skipped(self) -> "Queue":
        """The queue without its first item."""
        return self._of(self.items[1:])

    def cleared(self) -> "Queue":
        return self._of(())

    def halted(self, paused: bool) -> "Queue":
        """The queue, paused or not."""
        return Queue(self.items, paused, self.next)

    def _of(self, items: tuple[Item, ...]) -> "Queue":
        return Queue(items, self.paused, self.next)


EMPTY: Final = Queue()
