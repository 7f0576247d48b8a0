"""Whose turn it is in a pass of the ticker: the room that has had least time so far. Pure."""

from collections.abc import Iterable
from typing import Final

_MOST_AHEAD: Final = 1.0
"""s by which what a room has had counts for more than what any other has had: so long a room that
cost too much waits, at most, once others want as much."""

_FORGET: Final = 0.8  # of a room's usual cost, a pass later; the rest is the last pass's


class Shares:
    """How much time each room has had, for a fair share of a pass's `budget` in s.

    A room that costs little is always served. One that costs more than is left waits for its turn,
    so it is that room that slows down and no other.
    """

    def __init__(self, budget: float) -> None:
        self.budget = budget
        self.waited = 0  # turns that came too late in their pass
        self._owed = ""
        self._left = budget  # for all others
        self._had: dict[str, float] = {}
        self._usual: dict[str, float] = {}

    def order(self, rooms: Iterable[str], first: str) -> list[str]:
        """The rooms in the order of their turns in a pass, `first` before all others."""
        wanted = list(rooms)
        least = min((self._had[room] for room in wanted if room in self._had), default=0.0)
        had = {room: min(self._had.get(room, least), least + _MOST_AHEAD) for room in wanted}
        self._had = {room: value - least for room, value in had.items()}
        self._usual = {room: self._usual.get(room, 0.0) for room in wanted}
        turns = sorted(wanted, key=lambda room: (room != first, self._had[room]))
        others = turns[first in self._had :]
        # Whatever it costs, it is its turn; last, so that it delays nobody in this pass.
        self._owed = others[0] if others else ""
        kept = self._usual.get(self._owed, 0.0)
        self._left = max(self.budget - kept, 0.5 * self.budget)
        return [*turns[: len(turns) - len(others)], *others[1:], *others[:1]]

    def may_run(self, room: str, spent: float) -> bool:
        """Whether a room may still have its turn when so many s of the pass are spent."""
        fits = room == self._owed or spent + self._usual[room] <= self._left
        self.waited += not fits
        return fits

    def ran(self, room: str, seconds: float) -> None:
        """A room had its turn."""
        if room in self._had:
            self._had[room] += seconds
            usual = self._usual[room]
            self._usual[room] = max(seconds, _FORGET * usual + (1.0 - _FORGET) * seconds)
