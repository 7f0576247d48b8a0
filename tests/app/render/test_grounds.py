"""Backdrops of places in pictures: within the walls, at any size, and none at home.

tests/browser/test_places.py compares them with the page.
"""

import numpy as np
import pytest

from app.render.parts import ground
from app.render.parts.board import board_pixels
from app.render.parts.ground import Place
from app.render.parts.view import lay_out
from app.render.raster.canvas import Canvas
from app.render.theme import THEMES
from engine import Board

PLACES = [name for name, theme in THEMES.items() if theme.ground != "rays"]


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize(("width", "height"), [(240, 180), (2048, 90), (90, 700), (1, 1)])
def test_a_ground_is_painted_at_any_size_and_only_where_it_may(
    name: str, width: int, height: int
) -> None:
    theme = THEMES[name]
    clip = np.zeros((height, width), np.float32)
    clip[: height // 2] = 1.0
    for x in (0.5 * width, -1e7):
        canvas = Canvas.blank(width, height, theme["board"])
        ground.paint_surroundings(canvas, Place(x, 0.6, theme))
        assert np.isfinite(canvas.pixels).all()
        assert canvas.pixels.min() >= 0.0
        assert canvas.pixels.max() <= 255.0
        clipped = Canvas(canvas.pixels.copy(), clip)
        ground.paint_plate(clipped, Place(x, 0.6, theme))
        changed = (clipped.pixels != canvas.pixels).any(axis=-1)
        assert not changed[height // 2 :].any()
        assert changed.any() or height == 1 or x < 0.0


@pytest.mark.parametrize("preset", ["triangle-12", "classic", "galton"])
def test_a_place_changes_a_board_s_picture_inside_and_outside(preset: str) -> None:
    board = Board.preset(preset)
    view = lay_out(board, 300)
    home = board_pixels(board, view, "light")
    for name in PLACES:
        if not name.startswith("light"):
            continue
        theme = THEMES[name]
        pixels = board_pixels(board, view, name)
        assert pixels.shape == home.shape
        third = view.width // 3
        middle = pixels[round(view.header) + 2 : view.face - 2, third:-third]
        fade = np.linspace(0.0, 1.0, len(middle))[:, None, None]
        top, bottom = (np.array(theme[key], float) for key in ("board", "boardDeep"))
        printed = np.abs(middle - (top + fade * (bottom - top))).max(axis=-1) > 6.0
        assert printed.mean() > 0.1, f"{name} has more than enamel"
