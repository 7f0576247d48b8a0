"""Drops side by side: on boards without drag and friction each has the bits it has alone."""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.scenes import boards
from benchmarks.scenes.random_boards import random_board
from benchmarks.speed import throughput
from engine import Board, drop_many
from engine.board.parts import Peg
from engine.constants import MAX_TIME
from engine.exact import initial_state
from engine.exact.board_arrays import BoardArrays, arrays_of
from engine.exact.event_log import new_log
from engine.exact.grid import cells_of
from engine.exact.initial_state import at_rest, in_flight
from engine.exact.lockstep import lanes
from engine.exact.lockstep.trace import LeftOver, has_only_bounces, trace_bounces
from engine.exact.outcome import MAX_EVENTS, SEARCH_LIMIT, Results
from engine.exact.trace import trace_many
from engine.physics import body
from engine.physics.contact import new_series
from tests.engine.test_determinism import run_python

Array = npt.NDArray[Any]

BOARDS = {
    "thin pegs": boards.lattice(12, 24, throughput.THIN),
    "a triangle": boards.triangle(8, boards.PLAIN),
    "elastic": boards.lattice(6, 12, boards.PLAIN._replace(restitution=1.0)),
    "dead": boards.lattice(6, 12, boards.PLAIN._replace(restitution=0.0)),
    "bouncy": boards.triangle(10, boards.PLAIN._replace(restitution=0.9)),
}


def starts(board: Board, count: int) -> Array:
    """Places over all of the drop zone."""
    return board.drop.x + np.linspace(-0.99, 0.99, count) * board.drop.jitter


def columns(n: int) -> Results:
    """Room for the results of n drops, filled with what no drop gives."""
    return Results(
        bins=np.full(n, -9, np.int32),
        durations=np.full(n, -9.0),
        x_ends=np.full(n, -9.0),
        impacts=np.full(n, -9, np.int32),
        outcomes=np.full(n, -9, np.int8),
    )


def alone(
    arrays: BoardArrays, xs: Array, y: float, events: int = MAX_EVENTS, time: float = MAX_TIME
) -> list[Array]:
    """bins, durations, x_ends, impacts and outcomes of drops traced one by one."""
    return followed(arrays, at_rest(xs, y), in_flight(len(xs)), events, time)


def followed(
    arrays: BoardArrays, states: Array, initial: Array, events: int, time: float
) -> list[Array]:
    """The same of drops taken up where `initial` says."""
    bins, _, _, impacts, outcomes = columns(len(states))
    log = new_log(0, 0)
    trace_many(arrays, states, initial, events, time, new_series(), log, outcomes, bins, impacts)
    return [bins, states[:, body.T], states[:, body.X], impacts, outcomes]


def side_by_side(
    arrays: BoardArrays, xs: Array, y: float, events: int = MAX_EVENTS, time: float = MAX_TIME
) -> tuple[list[Array], LeftOver]:
    """The same of drops in a row, and those left over."""
    results = columns(len(xs))
    return list(results), trace_bounces(arrays, xs, y, events, time, results)


def agree(
    arrays: BoardArrays, xs: Array, y: float, events: int = MAX_EVENTS, time: float = MAX_TIME
) -> LeftOver:
    """Asserts that all drops have the bits they have alone; those that are left over, when they are
    taken up from there."""
    expected = alone(arrays, xs, y, events, time)
    found, left = side_by_side(arrays, xs, y, events, time)
    assert len(set(left.drops.tolist())) == len(left.drops)
    done = np.setdiff1d(np.arange(len(xs)), left.drops)
    late = followed(arrays, left.states.copy(), left.initial, events, time)
    for one, row, rest in zip(expected, found, late, strict=True):
        assert row[done].tobytes() == one[done].tobytes()
        assert (row[left.drops] == -9).all()
        assert rest.tobytes() == one[left.drops].tobytes()
    return left


def plain(board: Board) -> Board:
    """The board without its drag and friction."""
    return boards.revised(board, drag=0.0, ball=replace(board.ball, friction=0.0))


@pytest.mark.parametrize("name", BOARDS)
@pytest.mark.parametrize(
    "count", [1, lanes.LANES - 1, lanes.LANES, lanes.LANES + 1, 5 * lanes.LANES + 3]
)
def test_drops_side_by_side_are_those_one_by_one(name: str, count: int) -> None:
    board = BOARDS[name]
    agree(arrays_of(board), starts(board, count), board.drop.y)


@given(st.integers(0, 2**32 - 1))
def test_they_are_on_any_board(seed: int) -> None:
    board = plain(random_board(seed))
    arrays = arrays_of(board)
    assert has_only_bounces(arrays)
    agree(arrays, starts(board, 2 * lanes.LANES), board.drop.y)


def test_only_few_drops_are_left_over_and_they_are_those_that_touch_for_a_while() -> None:
    board = BOARDS["thin pegs"]
    left = agree(arrays_of(board), starts(board, 2000), board.drop.y)
    assert 0 < len(left.drops) < 0.05 * 2000
    assert (left.initial[:, initial_state.HIT] != initial_state.NONE).all()
    assert left.initial[:, initial_state.IMPACTS_BEFORE].min() > 20  # bounces that die are many
    none = agree(arrays_of(BOARDS["elastic"]), starts(board, 500), board.drop.y)
    assert len(none.drops) == 0


@pytest.mark.parametrize("cells_per_metre", [0.1, 1.0, 30.0])
def test_how_many_surfaces_a_cell_lists_changes_no_bit(cells_per_metre: float) -> None:
    """All of the board's in one cell, too: the searches' list runs over, and is taken in parts."""
    board = BOARDS["thin pegs"]
    fine = arrays_of(board)
    cells = cells_of(fine.items, board.ball.radius, fine.travel, cells_per_metre)
    arrays = fine._replace(**cells._asdict())
    if cells_per_metre < 1.0:
        assert np.diff(cells.starts.astype(np.int64)).max() > 4 * lanes.SLOTS
    xs = starts(board, 3 * lanes.LANES)
    for one, other in zip(
        alone(fine, xs, board.drop.y), alone(arrays, xs, board.drop.y), strict=True
    ):
        assert one.tobytes() == other.tobytes()
    assert len(agree(arrays, xs, board.drop.y).drops) < 0.1 * len(xs)


def test_on_a_board_without_any_surface_balls_fall_into_the_bins() -> None:
    bare = boards.unchecked(restitution=0.5, start=(0.0, 0.0), jitter=0.5, floor=3.0)
    arrays = arrays_of(bare)
    left = agree(arrays, starts(bare, 3 * lanes.LANES), bare.drop.y)
    assert len(left.drops) == 0
    assert (arrays.heads & lanes.FIRST_ITEM).max() < len(arrays.centres)  # it is read all the same


def test_a_drop_that_comes_to_a_limit_is_left_over() -> None:
    board = BOARDS["thin pegs"]
    arrays = arrays_of(board)
    xs = starts(board, 500)
    impacts, durations = alone(arrays, xs, board.drop.y)[3], alone(arrays, xs, board.drop.y)[1]
    left = agree(arrays, xs, board.drop.y, events=12)
    assert set(np.flatnonzero(impacts >= 12)) <= set(left.drops)
    left = agree(arrays, xs, board.drop.y, time=2.5)
    assert set(np.flatnonzero(durations > 2.5)) <= set(left.drops)
    assert 0 < len(left.drops) < 500


def test_a_ball_that_misses_the_board_holds_nobody_up() -> None:
    board = boards.unchecked(
        pegs=(Peg(0.0, 1.0, 0.1),), restitution=0.5, start=(0.0, 0.0), jitter=0.5
    )
    arrays = arrays_of(board)._replace(bins_y=1e12)
    xs = starts(board, 4)  # none in the middle: it would come to rest on the peg
    left = agree(arrays, xs, board.drop.y, time=1e9)
    assert len(left.drops) == 4
    assert set(alone(arrays, xs, board.drop.y, time=1e9)[4]) <= {SEARCH_LIMIT}
    assert lanes.PATIENCE * arrays.travel < 1e12


@pytest.mark.parametrize("change", [{"drag": 1e-9}, {"peg_friction": 0.1}, {"wall_friction": 0.1}])
def test_with_drag_or_friction_drops_go_one_by_one(change: dict[str, Any]) -> None:
    arrays = arrays_of(BOARDS["thin pegs"])
    assert has_only_bounces(arrays)
    assert not has_only_bounces(arrays._replace(**change))


def test_plain_python_gives_the_same_bits() -> None:
    code = (
        "from benchmarks.scenes import boards as scenes\n"
        "from benchmarks.speed import throughput\n"
        "from engine import drop_many\n"
        "print(drop_many(scenes.lattice(12, 24, throughput.THIN), range(12)).digest)\n"
    )
    compiled = drop_many(BOARDS["thin pegs"], range(12)).digest
    assert run_python(code, NUMBA_DISABLE_JIT="1") == f"{compiled}\n"
