"""Occupancy counts where balls spend their time, however the work is split."""

import importlib
import math
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, ParameterError, SeedError, drop, drop_many, occupancy
from plinko.engine.drops.occupancy import LONGEST_STEP, SHORTEST_STEP
from plinko.engine.physics import body

BOARD = Board.preset("triangle-8")
GRID: dict[str, Any] = {"left": -4.0, "top": -0.5, "cells_per_metre": 20.0, "shape": (140, 160)}
MODULE = importlib.import_module(
    "plinko.engine.drops.occupancy"
)  # the module; `plinko.engine.occupancy` is the function
WEYL = 0x9E3779B97F4A7C15


def looked_at(seed: int, step: float, duration: float) -> Any:
    """The times at which a drop is sampled."""
    phase = float((seed * WEYL % 2**64) >> 11) * 2.0**-53
    times = (np.arange(math.ceil(duration / step) + 1) + phase) * step
    return times[times < duration]


def by_hand(board: Board, seeds: range, step: float) -> np.ndarray[Any, np.dtype[np.int64]]:
    """The counts computed from the states of each drop."""
    rows, columns = GRID["shape"]
    counts = np.zeros((rows, columns), np.int64)
    for seed in seeds:
        d = drop(board, seed)
        states = d.states(looked_at(seed, step, d.duration))
        x = (states["x"] - GRID["left"]) * GRID["cells_per_metre"]
        y = (states["y"] - GRID["top"]) * GRID["cells_per_metre"]
        inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
        np.add.at(counts, (y[inside].astype(int), x[inside].astype(int)), 1)
    return counts


@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "classic", "galton"])
def test_balls_are_counted_where_their_paths_are(name: str) -> None:
    board, seeds = Board.preset(name), range(100, 140)
    found = occupancy(board, seeds, step=0.002, **GRID)
    wanted = by_hand(board, seeds, 0.002)
    # A sample on the edge of a cell may be rounded into the neighbouring cell.
    assert abs(found.counts - wanted).sum() <= 1e-4 * wanted.sum()
    assert found.counts.sum() > 1000


def test_balls_that_roll_are_counted_too() -> None:
    """A ball without restitution slides down a slope most of the time."""
    board = Board.from_json(
        {
            "ball": {"radius": 0.1, "restitution": 0.0},
            "peg_material": {"restitution": 0.0},
            "wall_material": {"restitution": 0.0},
            "walls": [
                {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 4.0},
                {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 4.0},
                {"x1": -1.5, "y1": 1.0, "x2": 0.8, "y2": 2.5},
            ],
            "bins": {"y": 3.5, "edges": [-1.5, 1.5], "multipliers": [1.0]},
            "drop": {"x": 0.0, "y": 0.0, "jitter": 0.3},
        }
    )
    path = drop(board, 3).trajectory
    assert (path.segments[:, 7] >= 0).any()
    found = occupancy(board, range(8), step=0.001, **GRID)
    wanted = by_hand(board, range(8), 0.001)
    assert abs(found.counts - wanted).sum() <= 1e-3 * wanted.sum()
    assert path.end[body.T] > 0.5


def test_the_counts_do_not_depend_on_how_the_work_is_split() -> None:
    whole = occupancy(BOARD, range(500), threads=1, **GRID)
    for threads in (2, 3):
        other = occupancy(BOARD, range(500), threads=threads, **GRID)
        assert (other.counts == whole.counts).all()
        assert other.duration == whole.duration
    first, second = (occupancy(BOARD, seeds, **GRID) for seeds in (range(200), range(200, 500)))
    assert (first.counts + second.counts == whole.counts).all()


def test_the_outcomes_are_those_of_the_drops() -> None:
    many = drop_many(BOARD, range(300))
    found = occupancy(BOARD, range(300), **GRID)
    assert found.histogram.tolist() == many.histogram.tolist()
    assert found.unsettled_count == many.unsettled_count
    assert found.duration == pytest.approx(many.duration.sum(), rel=1e-12)
    assert found.drops == 300


def test_all_time_is_counted_on_a_grid_that_holds_the_board() -> None:
    found = occupancy(BOARD, range(300), **GRID)
    assert found.counts.sum() * found.step == pytest.approx(found.duration, rel=1e-3)
    assert found.seconds.sum() == pytest.approx(found.duration / 300, rel=1e-3)


@pytest.mark.parametrize("room", [3, 400])
def test_drops_too_long_for_the_log_are_followed_all_the_same(
    room: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """3 segments are too few for any drop, and 400 are too few for 128 drops together."""
    whole = occupancy(BOARD, range(150), **GRID)
    monkeypatch.setattr(MODULE, "_SEGMENTS", room)
    parts = occupancy(BOARD, range(150), **GRID)
    assert (parts.counts == whole.counts).all()
    assert (parts.histogram == whole.histogram).all()
    assert parts.duration == whole.duration


def test_nothing_outside_of_the_grid_is_counted() -> None:
    far = occupancy(BOARD, range(20), **GRID | {"left": 100.0})
    assert far.counts.sum() == 0
    assert far.histogram.sum() == 20
    half = occupancy(BOARD, range(20), **GRID | {"left": 0.0})
    assert 0 < half.counts.sum() < occupancy(BOARD, range(20), **GRID).counts.sum()


def test_a_drop_that_never_ends_is_looked_at_while_it_lasts() -> None:
    board = Board.from_json(
        {
            "walls": [
                {"x1": -1.0, "y1": -1.0, "x2": -1.0, "y2": 4.0},
                {"x1": 1.0, "y1": -1.0, "x2": 1.0, "y2": 4.0},
            ],
            "pegs": [{"x": 0.0, "y": 2.0, "radius": 0.3}],
            "bins": {"y": 3.0, "edges": [-1.0, 1.0], "multipliers": [1.0]},
            "drop": {"x": 0.0, "y": 0.0, "jitter": 0.0},
        }
    )
    found = occupancy(board, range(3), **GRID)
    assert (found.unsettled_count, found.histogram.sum()) == (3, 0)
    assert found.counts.sum() * found.step == pytest.approx(found.duration, rel=1e-2)


def test_many_drops_are_looked_at_less_often_each() -> None:
    assert occupancy(BOARD, range(10), **GRID).step == SHORTEST_STEP
    assert MODULE.default_step(10**6) == LONGEST_STEP
    assert SHORTEST_STEP < MODULE.default_step(50_000) < LONGEST_STEP


def test_progress_is_told_and_may_stop_the_work() -> None:
    told: list[int] = []
    occupancy(BOARD, range(300), progress=told.append, **GRID)
    assert told[-1] == 300
    assert told == sorted(told)

    def enough(done: int) -> None:
        raise ZeroDivisionError(done)

    with pytest.raises(ZeroDivisionError):
        occupancy(BOARD, range(10_000), progress=enough, **GRID)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"shape": (0, 10)}, "shape"),
        ({"shape": (10_000, 10_000)}, "shape"),
        ({"cells_per_metre": 0.0}, "cells_per_metre 0.0"),
        ({"left": math.nan}, "left nan"),
        ({"top": math.inf}, "top inf"),
        ({"step": 0.0}, "step 0.0"),
        ({"threads": 0}, "threads 0"),
    ],
)
def test_what_cannot_be_counted_is_named(changes: dict[str, Any], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        occupancy(BOARD, range(3), **GRID | changes)


def test_a_bad_seed_is_named() -> None:
    with pytest.raises(SeedError, match="-1"):
        occupancy(BOARD, [-1], **GRID)
