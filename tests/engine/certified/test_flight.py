"""A flight's state at a time that is an interval encloses its states at all times within."""

import pytest
from flint import arb

from plinko.engine import Board
from plinko.engine.certified.balls import UndecidedError, precision
from plinko.engine.certified.flight import Flight, State
from plinko.engine.certified.scene import scene_of


def test_the_state_at_a_wide_time_encloses_its_ends_or_is_undecided() -> None:
    board = Board.preset("triangle-8").replace(drag=20.0)
    with precision(160):
        start = State(*map(arb, (0, 0.1, 0.2, 3, 1, 0)))
        flight = Flight(scene_of(board, 160), start)
        wide = flight.moment(arb(0.5, 0.02))  # k|d| = 0.4
        for end in (arb(0.481), arb(0.519)):
            exact = flight.moment(end)
            assert all(found.contains(each) for found, each in zip(wide, exact, strict=True))
        with pytest.raises(UndecidedError):
            flight.moment(arb(0.5, 0.03))  # k|d| = 0.6
