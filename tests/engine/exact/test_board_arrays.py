"""The flat form of a board: cells, bins, and a grid that saves work and changes no result."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.scenes.contact_scenes import scene, scene_names
from benchmarks.scenes.expensive_boards import crowded, large
from plinko.engine import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.trajectory import at_start
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import BoardArrays, arrays_of, bin_of, cell_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.grid import HEAD_BITS, HEAD_MANY, MAX_CELLS, MAX_LISTED, Cells, cells_of
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.physics import surface
from plinko.engine.seeding import start_x
from plinko.engine.stepped.step import trace_stepped_many
from plinko.engine.stepped.sweep import sweep
from tests.engine.exact.one_ball import trace
from tests.engine.multibody.static_scenes import any_board
from tools.boards.wall_boards import wall_board, wall_boards

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
BOARDS = ("triangle-8", "classic", "galton")


def board_of(name: str) -> Board:
    return Board.preset(name) if name in BOARDS else scene(name).board


def gridless(board: Board) -> BoardArrays:
    """The board's arrays with one cell that lists every surface that owns itself."""
    arrays = arrays_of(board)
    owners = arrays.items[:, surface.OWNER] == np.arange(len(arrays.items))
    members = np.flatnonzero(owners).astype(np.uint32)
    starts = np.array([0, len(members)], np.uint32)
    head = int(members[0]) | min(len(members), HEAD_MANY) << HEAD_BITS if len(members) else 0
    cells = Cells(0.0, 0.0, 1.0, 0, 0, starts, members, np.array([head], np.uint32))
    return arrays._replace(**cells._asdict())


@pytest.mark.parametrize(
    ("x", "y"),
    [(1e300, 0.0), (0.0, -1e300), (math.inf, 0.0), (0.0, -math.inf), (math.nan, 0.0), (1e12, 1.0)],
)
def test_a_place_too_far_out_has_no_cell(x: float, y: float) -> None:
    assert cell_of(arrays_of(Board.preset("triangle-8")), x, y) == -1


def test_a_place_on_the_board_or_somewhat_off_it_has_a_cell() -> None:
    arrays = arrays_of(Board.preset("triangle-8"))
    count = len(arrays.starts) - 1
    for x in np.linspace(-1000.0, 1000.0, 21):
        assert 0 <= cell_of(arrays, float(x), -0.37 * float(x)) < count


def test_surfaces_far_apart_have_coarser_cells_instead_of_more() -> None:
    items = np.zeros((2, surface.COLUMNS))
    items[:, [surface.X, surface.Y, surface.DISTANCE, surface.DISTANCE2, surface.OWNER]] = [
        [-1e6, 0.0, 0.1, 0.01, 0],
        [1e6, 5.0, 0.1, 0.01, 1],
    ]
    cells = cells_of(items, 0.05, 0.2, 10.0)
    assert cells.columns * cells.rows <= MAX_CELLS
    assert cells.cells_per_metre < 1.0
    assert set(cells.members.tolist()) == {0, 1}


def test_no_cell_lists_a_surface_that_another_one_owns() -> None:
    arrays = arrays_of(wall_board(3))
    owners = arrays.items[:, surface.OWNER] == np.arange(len(arrays.items))
    assert 0 < np.count_nonzero(owners) < len(owners)
    assert set(arrays.members.tolist()) == set(np.flatnonzero(owners).tolist())


def walled(width: float, height: float, *walls: tuple[float, float, float, float]) -> Board:
    return Board.from_json(
        {
            "width": width,
            "height": height,
            "walls": [dict(zip(("x1", "y1", "x2", "y2"), wall, strict=True)) for wall in walls],
            "bins": {"y": 3.0, "edges": [-1.0, 1.0]},
            "drop": {"x": 0.0},
        }
    )


def test_without_two_pegs_the_search_depends_on_straight_walls_and_not_on_the_drawing() -> None:
    sides = (-1.0, -1.0, -1.0, 1.0), (1.0, -1.0, 1.0, 1.0)
    whole = [(-1.0, -1.0, -1.0, 3.0), (1.0, -1.0, 1.0, 3.0)]
    cut = [*sides, (-1.0, 1.0, -1.0, 3.0), (1.0, 3.0, 1.0, 1.0)]
    travels = {
        arrays_of(walled(width, 4.0, *walls)).travel
        for width in (2.0, 20.0)
        for walls in (whole, cut)
    }
    assert travels == {0.35 * (4.0 / 8.0)}


@pytest.mark.parametrize(
    "form",
    [
        pytest.param(large(), id="large"),
        pytest.param(crowded(), id="crowded", marks=pytest.mark.long("slow to check")),
    ],
)
def test_a_large_board_s_arrays_are_small_and_change_no_path(
    form: dict[str, Any],
) -> None:
    board = Board.from_json(form)
    arrays = arrays_of(board)
    assert len(arrays.heads) - 1 <= MAX_CELLS
    assert len(arrays.members) <= MAX_LISTED
    assert sum(each.nbytes for each in arrays if isinstance(each, np.ndarray)) < 3e6
    assert grid_changes_nothing(board, 0.1)


@given(st.floats(-10.0, 10.0))
def test_a_bin_is_closed_on_its_left_and_the_outer_ones_are_open(x: float) -> None:
    board = Board.preset("triangle-8")
    edges = board.bins.edges
    inner = sum(1 for edge in edges[1:-1] if edge <= x)
    assert bin_of(arrays_of(board), x) == inner


def test_each_edge_belongs_to_the_bin_on_its_right() -> None:
    board = Board.preset("classic")
    for i, edge in enumerate(board.bins.edges[:-1]):
        assert bin_of(arrays_of(board), edge) == i


@pytest.mark.parametrize("name", [*BOARDS, *scene_names()])
def test_the_grid_changes_no_bit_of_an_exact_drop(name: str) -> None:
    """Every cell therefore lists all surfaces that a ball can touch from it."""
    board = board_of(name)
    for seed in range(4):
        assert grid_changes_nothing(board, start_x(seed, board.drop.x, board.drop.jitter))


@given(wall_boards, st.floats(-0.9, 0.9))
def test_the_grid_changes_no_bit_on_walls_in_pieces(board: Board, x: float) -> None:
    assert grid_changes_nothing(board, x)


@given(any_board, st.floats(-0.9, 0.9))
def test_the_grid_changes_no_bit_on_any_board(board: Board, x: float) -> None:
    assert grid_changes_nothing(board, x)


@pytest.mark.parametrize("name", [*BOARDS, "storm", "zigzag", "comb"])
def test_the_grid_changes_no_bit_of_a_stepped_drop(name: str) -> None:
    board = board_of(name)
    for seed in range(2):
        x = start_x(seed, board.drop.x, board.drop.jitter)
        results = []
        for arrays in (arrays_of(board), gridless(board)):
            state, log = at_start(board, x), new_log(500, 0)
            ends = np.zeros(1, np.int8), np.zeros(1, np.int32), np.zeros(1, np.int32)
            trace_stepped_many(
                arrays, state.reshape(1, -1), 1.0 / 240.0, 0.6, MAX_EVENTS, log, *ends
            )
            outcome, where, _ = (int(end[0]) for end in ends)
            count = int(log.counts[event_log.EVENTS])
            told = log.events[:count].tobytes(), log.marks[:count].tobytes()
            results.append((outcome, where, *told))
        assert results[0] == results[1]


def grid_changes_nothing(board: Board, x: float) -> bool:
    """Whether an exact drop has the same first 2000 events with a single cell for all surfaces."""
    results = []
    for arrays in (arrays_of(board), gridless(board)):
        state, log = at_start(board, x), new_log(2000, 0)
        outcome = trace(arrays, state, MAX_EVENTS, MAX_TIME, log)
        count = min(int(log.counts[event_log.EVENTS]), 2000)
        results.append((outcome, log.events[:count].tobytes(), log.marks[:count].tobytes()))
    return results[0] == results[1]


@given(st.floats(-3.0, 3.0), st.floats(0.0, 5.0), st.floats(-1e5, 1e5), st.floats(-1e5, 1e5))
def test_a_sweep_finds_the_first_surface_on_a_straight_line(
    x: float, y: float, vx: float, vy: float
) -> None:
    """Compare with samples along the line: the ball touches nothing before the end point."""
    board = Board.preset("triangle-8")
    arrays = gridless(board)
    horizon = 0.5 / (math.hypot(vx, vy) + 1e-9)
    gap = gaps(board, np.array([x]), np.array([y]))
    if gap.min() < 0.0:
        return
    with np.errstate(over="ignore"):  # an infinite time means no impact
        s, item, _ = sweep(arrays, 0, x, y, vx, vy, horizon, -1)
    t = np.linspace(0.0, s, 400)
    path = gaps(board, x + vx * t, y + vy * t)
    assert path.min() > -1e-12
    if item < 0:
        assert s == horizon
    else:
        assert path[:, -1].min() < 1e-12


def gaps(board: Board, x: Floats, y: Floats) -> Floats:
    """Distance in m of a ball's centre at each place from each surface, shape (surfaces,
    places)."""
    rows = [np.hypot(x - p.x, y - p.y) - p.radius for p in board.pegs]
    for w in board.walls:
        tx, ty = w.x2 - w.x1, w.y2 - w.y1
        along = np.clip(((x - w.x1) * tx + (y - w.y1) * ty) / (tx * tx + ty * ty), 0.0, 1.0)
        rows.append(np.hypot(x - w.x1 - along * tx, y - w.y1 - along * ty))
    return np.array(rows) - board.ball.radius
