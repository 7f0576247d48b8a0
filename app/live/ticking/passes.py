"""Decides which room runs next in a pass of the ticker, and for how long. Pure.

When ticks are due, the ticker makes a pass: every awake room has a turn. The rooms share the time
of a pass equally: each may use the remaining time divided by the number of rooms still to come. A
room that needs less leaves the rest to those after it. One that needs more continues in the next
pass, so only this room slows down. The length of earlier turns does not count: if the machine
interrupts a turn for a second, the room does not pay for it later.
"""

import math
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple


class Turn(NamedTuple):
    """A room, and the time until which it may begin further computations."""

    room_id: str
    until: float


class Pass:
    """One pass over the awake rooms, in the given order.

    The room `first` comes before all others and may take as long as it needs. Even if no time is
    left, one of the others has a turn; the rest are skipped. The caller puts the rooms that have
    waited longest first, so n rooms have all had a turn after at most n passes.
    """

    def __init__(self, rooms: Iterable[str], first: str, began: float, budget: float) -> None:
        self.coming = deque(rooms)
        """The rooms that have not had a turn yet."""
        self._end = began + budget
        self._first = first in self.coming
        self._others = 0  # other rooms that have had a turn
        if self._first:
            self.coming.remove(first)
            self.coming.appendleft(first)

    def next(self, now: float) -> Turn | None:
        """The next turn at `now`; None if all rooms have had one or the time is used up."""
        if not self.coming:
            return None
        if self._first:
            self._first = False
            return Turn(self.coming.popleft(), math.inf)
        left = self._end - now
        if left <= 0.0 and self._others > 0:
            return None
        self._others += 1
        return Turn(self.coming.popleft(), now + max(0.0, left) / (len(self.coming) + 1))
