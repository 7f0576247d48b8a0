"""Which room runs next in a pass of the ticker, and for how long. Pure: the caller brings the time.

A pass is what the ticker does when ticks are due: every awake room has a turn. The rooms divide the
time of a pass equally: each may use what is left of it, divided by the rooms still to come. A room
that needs less leaves the rest to those after it; one that needs more goes on in the next pass, so
it slows down and no other does. Nothing is remembered of what a turn took: a turn that the machine
interrupted for a second costs its room nothing later.
"""

import math
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple


class Turn(NamedTuple):
    """A room, and the time until which it may compute. What it has begun by then it finishes."""

    room_id: str
    until: float


class Pass:
    """One pass over the rooms that are awake, in the order in which they are given.

    `first` comes before all others and has as long as it needs. Once the time is used up, one of
    the others still has its turn; those after it are skipped. The caller gives the rooms that have
    waited longest first, so n rooms all had a turn after at most n passes.
    """

    def __init__(self, rooms: Iterable[str], first: str, began: float, budget: float) -> None:
        self.coming = deque(rooms)
        """The rooms that had no turn yet."""
        self._end = began + budget
        self._first = first in self.coming
        self._others = 0  # that had their turn
        if self._first:
            self.coming.remove(first)
            self.coming.appendleft(first)

    def next(self, now: float) -> Turn | None:
        """Whose turn it is at `now`; None when all had theirs or there is no time for more."""
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
