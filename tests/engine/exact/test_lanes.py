"""Drops in lanes have the same bits as single drops, on any board."""

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from benchmarks.scenes import boards
from benchmarks.scenes.random_boards import random_board
from plinko.engine import Board
from plinko.engine.board.parts import Peg
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.grid import cells_of
from plinko.engine.exact.initial_state import at_rest, in_flight
from plinko.engine.exact.lanes import flight, lane
from plinko.engine.exact.lanes.trace import KERNELS, Code, Drops, is_plain, trace_drops
from plinko.engine.exact.outcome import (
    EVENT_LIMIT,
    MAX_EVENTS,
    SEARCH_LIMIT,
    TIME_LIMIT,
    Results,
    new_results,
)
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit import native
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series
from plinko.engine.seeding import start_xs
from tests.kit.python import run_python
from tests.long import tries
from tools.boards.hard_boards import KINDS, HardBoard, hard_boards, numbered

Array = npt.NDArray[Any]

DROPS = tries(500, 10_000)

CASES = Path(__file__).parents[2] / "regressions" / "contacts"


def plain(board: Board) -> Board:
    """The board without its drag and friction."""
    return replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))


def lossy(board: Board) -> Board:
    """The board with nearly no restitution, so that balls mostly roll."""
    dull = replace(board.ball.material, restitution=0.05)
    return replace(board, ball=replace(board.ball, restitution=0.05), peg_material=dull)


BOARDS = {
    "thin pegs": boards.lattice(12, 24, boards.THIN),
    "a triangle": boards.triangle(8, boards.PLAIN),
    "elastic": boards.lattice(6, 12, boards.PLAIN._replace(restitution=1.0)),
    "dead": boards.lattice(6, 12, boards.PLAIN._replace(restitution=0.0)),
    "bouncy": boards.triangle(10, boards.PLAIN._replace(restitution=0.9)),
    "triangle-16": Board.preset("triangle-16"),
    "triangle-8": Board.preset("triangle-8"),
    "classic": Board.preset("classic"),
    "galton": Board.preset("galton"),
    "plain triangle-12": plain(Board.preset("triangle-12")),
    "drag of 0.1/s": replace(Board.preset("triangle-12"), drag=0.1),
    "drag of 20/s": replace(Board.preset("triangle-12"), drag=20.0),
    "restitution of 0.05": lossy(Board.preset("triangle-12")),
    "friction without drag": replace(Board.preset("triangle-12"), drag=0.0),
}


@cache
def code() -> Mapping[str, Code]:
    """Native code of the lanes; without it the kernels, which numba compiles."""
    try:
        return native.load()
    except native.NoNativeCodeError:
        return KERNELS


def starts(board: Board, count: int) -> Array:
    """Starts all over the drop zone."""
    return board.drop.x + np.linspace(-0.99, 0.99, count) * board.drop.jitter


def alone(
    arrays: BoardArrays, xs: Array, y: float, events: int = MAX_EVENTS, time: float = MAX_TIME
) -> Results:
    """Outcomes of drops traced one by one."""
    states, found = at_rest(xs, y), new_results(len(xs))
    trace_many(
        arrays, states, in_flight(len(xs)), events, time, new_series(), new_log(0, 0),
        found.outcomes, found.bins, found.impacts,
    )  # fmt: skip
    return found._replace(durations=states[:, body.T], x_ends=states[:, body.X])


def agree(
    arrays: BoardArrays, xs: Array, y: float, events: int = MAX_EVENTS, time: float = MAX_TIME
) -> Results:
    """Assert that drops in lanes have the same bits as single drops."""
    expected, found = alone(arrays, xs, y, events, time), new_results(len(xs))
    with np.errstate(all="ignore"):  # lanes whose search has ended still compute with the others
        trace_drops(arrays, Drops(xs, y, events, time), found, code())
    assert bits(found) == bits(expected)
    return found


def bits(results: Results) -> list[bytes]:
    """The bytes of each column."""
    columns: tuple[Array, ...] = results
    return [column.tobytes() for column in columns]


@pytest.mark.parametrize("name", BOARDS)
def test_lanes_give_single_drops(name: str) -> None:
    board = BOARDS[name]
    xs = start_xs(np.arange(DROPS, dtype=np.uint64), board.drop.x, board.drop.jitter)
    agree(arrays_of(board), xs, board.drop.y)


@pytest.mark.parametrize("name", ["thin pegs", "triangle-8"])
@pytest.mark.parametrize(
    "count", [1, lane.LANES - 1, lane.LANES, lane.LANES + 1, 5 * lane.LANES + 3]
)
def test_lanes_give_single_drops_for_any_count(name: str, count: int) -> None:
    board = BOARDS[name]
    agree(arrays_of(board), starts(board, count), board.drop.y)


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_lanes_give_single_drops_on_any_board(seed: int, is_smooth: bool) -> None:
    board = plain(random_board(seed)) if is_smooth else random_board(seed)
    assert is_plain(arrays_of(board)) or not is_smooth
    agree(arrays_of(board), starts(board, 2 * lane.LANES), board.drop.y)


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(hard_boards)
def test_lanes_give_single_drops_on_any_hard_board(hard: HardBoard) -> None:
    board = hard.playable()
    assume(board is not None)
    assert board is not None
    agree(arrays_of(board), np.append(starts(board, 20), hard.starts), board.drop.y)


@pytest.mark.parametrize("kind", KINDS)
def test_lanes_give_single_drops_on_each_kind_of_hard_board(kind: str) -> None:
    made = 0
    for hard in numbered(kind):
        if (board := hard.playable()) is not None:
            made += 1
            agree(arrays_of(board), np.append(starts(board, 20), hard.starts), board.drop.y)
        if made == tries(3, 40):
            break


@pytest.mark.parametrize("file", sorted(CASES.glob("*.json")), ids=lambda file: file.stem)
def test_lanes_give_single_drops_on_boards_that_once_hung(file: Path) -> None:
    for case in json.loads(file.read_text(encoding="utf-8")):
        board = Board.from_json(case["board"])
        seed = np.array([case["seed"]], np.uint64)
        xs = start_xs(seed, board.drop.x, board.drop.jitter)
        agree(arrays_of(board), np.append(xs, starts(board, 10)), board.drop.y)


@pytest.mark.parametrize("cells_per_metre", [0.1, 1.0, 10.0])
def test_how_many_surfaces_a_cell_lists_changes_no_bit(cells_per_metre: float) -> None:
    """With one cell for all surfaces, the list of searches is too long for one pass."""
    board = BOARDS["thin pegs"]
    fine = arrays_of(board)
    cells = cells_of(fine.items, board.ball.radius, fine.travel, cells_per_metre)
    arrays = fine._replace(**cells._asdict())
    if cells_per_metre < 1.0:
        assert np.diff(cells.starts.astype(np.int64)).max() > 4 * lane.SLOTS
    xs = starts(board, 3 * lane.LANES)
    assert bits(alone(fine, xs, board.drop.y)) == bits(agree(arrays, xs, board.drop.y))


def test_on_a_board_without_any_surface_balls_fall_into_the_bins() -> None:
    bare = boards.unchecked(restitution=0.5, start=(0.0, 0.0), jitter=0.5, floor=3.0)
    arrays = arrays_of(bare)
    agree(arrays, starts(bare, 3 * lane.LANES), bare.drop.y)
    assert (arrays.heads & flight.FIRST_ITEM).max() < len(arrays.centres)  # it is read nevertheless


@pytest.mark.parametrize("name", ["thin pegs", "triangle-16", "restitution of 0.05"])
def test_a_drop_that_comes_to_a_limit_ends_there(name: str) -> None:
    board = BOARDS[name]
    xs = starts(board, 500)
    for events in (1, 2, 12):
        ended = agree(arrays_of(board), xs, board.drop.y, events=events)
        assert EVENT_LIMIT in ended.outcomes
    ended = agree(arrays_of(board), xs, board.drop.y, time=2.5)
    assert TIME_LIMIT in ended.outcomes


def test_a_ball_that_misses_the_board_delays_no_other() -> None:
    board = boards.unchecked(
        pegs=(Peg(0.0, 1.0, 0.1),), restitution=0.5, start=(0.0, 0.0), jitter=0.5
    )
    arrays = arrays_of(board)._replace(bins_y=1e12)
    xs = starts(board, 4)  # no start in the middle: that ball would come to rest on the peg
    ended = agree(arrays, xs, board.drop.y, time=1e9)
    assert set(ended.outcomes) == {SEARCH_LIMIT}
    assert flight.PATIENCE * arrays.travel < 1e12


def test_plain_python_gives_the_same_bits() -> None:
    program = (
        "from tests.engine.exact.test_lanes import BOARDS, agree, arrays_of, code, starts\n"
        "for name in ('thin pegs', 'triangle-8'):\n"
        "    board = BOARDS[name]\n"
        "    found = agree(arrays_of(board), starts(board, 12), board.drop.y)\n"
        "    print(found.durations.tobytes().hex())\n"
    )
    both = [BOARDS[name] for name in ("thin pegs", "triangle-8")]
    compiled = [agree(arrays_of(b), starts(b, 12), b.drop.y).durations for b in both]
    found = run_python(program, NUMBA_DISABLE_JIT="1").split()
    assert found == [durations.tobytes().hex() for durations in compiled]
