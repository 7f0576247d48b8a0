"""Walls in pictures: side walls have their rail outside, inner walls on themselves."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from plinko.app.render.parts.board import board_pixels, sides_of
from plinko.app.render.parts.view import lay_out
from plinko.app.render.theme import named
from plinko.engine import Board
from tests.app.conftest import TINY
from tests.kit.presets import SAMPLE

SIDES = [{"x1": side * 1.5, "y1": -1.0, "x2": side * 1.5, "y2": 2.0} for side in (-1.0, 1.0)]


def walled(*walls: dict[str, float], **more: Any) -> Board:
    return Board.from_json({**TINY, "pegs": [], "walls": [*SIDES, *walls], **more})


def closed(*corners: tuple[float, float]) -> list[dict[str, float]]:
    """Walls from corner to corner, and back to the first corner."""
    ends = itertools.pairwise([*corners, corners[0]])
    return [{"x1": a[0], "y1": a[1], "x2": b[0], "y2": b[1]} for a, b in ends]


def hexagon(x: float) -> list[dict[str, float]]:
    """A hexagon around (x, 1), with a corner on top."""
    angles = (math.pi * k / 3.0 for k in range(6))
    return closed(*((x + 0.4 * math.sin(a), 1.0 - 0.4 * math.cos(a)) for a in angles))


HEXAGON = walled(*hexagon(0.0))


@pytest.mark.parametrize("name", SAMPLE)
def test_all_walls_of_presets_are_at_the_side_where_they_are(name: str) -> None:
    board = Board.preset(name)
    assert sides_of(board) == tuple(1 if wall.x1 + wall.x2 > 0.0 else -1 for wall in board.walls)


@pytest.mark.parametrize("x", [0.0, 0.5, -0.5])
def test_walls_inside_a_board_are_at_no_side(x: float) -> None:
    assert sides_of(walled(*hexagon(x))) == (-1, 1, 0, 0, 0, 0, 0, 0)
    ramp = {"x1": -1.5, "y1": 0.5, "x2": -0.75, "y2": 0.875}
    assert sides_of(walled(ramp)) == (-1, 1, 0)


def test_walls_that_lead_to_the_bins_outer_ends_are_at_the_sides() -> None:
    """Side walls in two pieces, as a funnel. A lid that joins both sides belongs to neither."""
    pieces = [
        {"x1": -0.75, "y1": -1.0, "x2": -0.75, "y2": 0.5},
        {"x1": -0.75, "y1": 0.5, "x2": -1.5, "y2": 2.0},
        {"x1": 0.75, "y1": -1.0, "x2": 0.75, "y2": 0.5},
        {"x1": 1.5, "y1": 2.0, "x2": 0.75, "y2": 0.5},
    ]
    lid = {"x1": -0.75, "y1": -1.0, "x2": 0.75, "y2": -1.0}
    narrow = {"drop": {"x": 0.0, "y": 0.0, "jitter": 0.25}}
    board = Board.from_json({**TINY, "pegs": [], "walls": pieces, **narrow})
    assert sides_of(board) == (-1, -1, 1, 1)
    board = Board.from_json({**TINY, "pegs": [], "walls": [*pieces, lid], **narrow})
    assert sides_of(board) == (-1, -1, 1, 1, 0)


def test_an_inner_wall_s_rail_lies_on_it_and_closes_its_corner() -> None:
    view = lay_out(HEXAGON, 600)
    pixels = board_pixels(HEXAGON, view, "light").astype(int)
    rail = np.array(named("light")["rail"])
    inside = HEXAGON.walls[2:]
    for wall in inside:
        for part in np.linspace(0.0, 1.0, 21):
            x = view.px(wall.x1 + part * (wall.x2 - wall.x1))
            y = view.py(wall.y1 + part * (wall.y2 - wall.y1))
            assert np.abs(pixels[round(y), round(x)] - rail).max() <= 2, (x, y)


def test_the_plate_goes_on_around_walls_inside() -> None:
    """Only side walls end the plate: it is the same with and without the hexagon."""
    bare = walled()
    view = lay_out(HEXAGON, 600)
    assert view == lay_out(bare, 600)
    one, other = (board_pixels(board, view, "light").astype(int) for board in (HEXAGON, bare))
    rail = 0.12 * view.scale  # pixels; the hexagon's rail and shadow reach less far
    rows, columns = np.mgrid[: view.height, : view.width]
    reach = 0.4 * view.scale + rail
    away = np.hypot(columns - view.px(0.0), rows - view.py(1.0)) > reach
    assert (one[away] == other[away]).all()
