"""What waits to be dropped into a room: items of some balls each, for somebody. Pure."""

from typing import Final

import msgspec

from app.errors import BallLimitError
from app.protocol.visitors import NO_TAG, Tag
from app.rooms.pending import again_of

MOST_ITEMS: Final = 100
MOST_BALLS: Final = 1000  # of one item
MOST_WAITING: Final = 5000  # balls of all items


class Item(msgspec.Struct, frozen=True, omit_defaults=True):
    """Balls that wait, dropped one `every` s; `number` identifies the item in this run of the room.

    again: the key under which a client may repeat the request.
    """

    number: int
    balls: int
    every: float
    tag: Tag = NO_TAG
    again: str | None = None

    def key(self, ball: int) -> str:
        """By which its ball of this number is dropped once, whatever happens in between."""
        return ball_key(self.again or str(self.number), ball)


def ball_key(item: str, ball: int) -> str:
    """The key of a ball of an item, which the ledger has once the ball was dropped."""
    return again_of("queue", item, str(ball))


class Queue(msgspec.Struct, frozen=True, omit_defaults=True):
    """The items in their order, the first one being dropped unless it is paused."""

    items: tuple[Item, ...] = ()
    paused: bool = False
    next: int = 0

    def with_item(self, balls: int, every: float, tag: Tag, again: str | None = None) -> "Queue":
        """With one more at its end; raises BallLimitError where that is too much."""
        if len(self.items) >= MOST_ITEMS:
            raise BallLimitError(f"{MOST_ITEMS} items wait already, as many as may")
        waiting = sum(item.balls for item in self.items)
        if waiting + balls > MOST_WAITING:
            raise BallLimitError(
                f"n {balls}: {waiting} balls wait already, and no more than {MOST_WAITING} may",
                field="n",
            )
        item = Item(self.next, balls, every, tag, again)
        return Queue((*self.items, item), self.paused, self.next + 1)

    def without(self, number: int) -> "Queue":
        """Without the item of this number."""
        return self._of(tuple(item for item in self.items if item.number != number))

    def skipped(self) -> "Queue":
        """Without its first item."""
        return self._of(self.items[1:])

    def cleared(self) -> "Queue":
        """Without items."""
        return self._of(())

    def halted(self, paused: bool) -> "Queue":
        """Paused or not."""
        return Queue(self.items, paused, self.next)

    def _of(self, items: tuple[Item, ...]) -> "Queue":
        return Queue(items, self.paused, self.next)


EMPTY: Final = Queue()
