"""Backdrops of places in pictures: within the walls, at any size, and none at home.

tests/browser/test_places.py compares them with the page.
"""

import io
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from plinko.app.render import (
    Stage,
    contact_sheet,
    density_picture,
    drop_animation,
    drop_picture,
    histogram_picture,
)
from plinko.app.render.notebook import png
from plinko.app.render.parts import ground
from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.ground import Place
from plinko.app.render.parts.view import lay_out
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.start_map import map_picture
from plinko.app.render.theme import THEMES
from plinko.engine import Board, drop
from plinko.engine.certified.start_map import strip_at
from tests.long import tries

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


@pytest.mark.long
@pytest.mark.parametrize("preset", tries(["triangle-12"], ["triangle-12", "classic", "galton"]))
def test_a_place_changes_a_board_s_picture_inside_and_outside(preset: str) -> None:
    board = Board.preset(preset)
    view = lay_out(board, 240)
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


Draw = Callable[[Board], bytes | npt.NDArray[np.uint8]]

DRAWN: dict[str, Draw] = {
    "a drop": lambda board: drop_picture(drop(board, 1), width=300),
    "a moment": lambda board: drop_picture(drop(board, 1), width=300, at=0.5),
    "an animation": lambda board: drop_animation(drop(board, 1), "gif", 300, 1),
    "a sheet": lambda board: contact_sheet(board, range(1), width=300),
    "a density": lambda board: density_picture(board, range(1), width=300),
    "a board": png,
    "a room": lambda board: Stage(board, 300)._bare,
}
CHARTS: dict[str, Draw] = {
    "a histogram": lambda board: histogram_picture(board, np.ones(9), width=300),
    "a map": lambda board: map_picture(board, [strip_at(board, 0, 0, 2)]),
}


def shares(
    drawn: bytes | npt.NDArray[np.uint8], name: str, colours: tuple[str, ...]
) -> list[float]:
    """The share of pixels in each of these colours of the theme."""
    if isinstance(drawn, bytes):
        with Image.open(io.BytesIO(drawn)) as image:
            drawn = np.asarray(image.convert("RGB"))
    return [float((drawn == THEMES[name][colour]).all(axis=-1).mean()) for colour in colours]


WORLDS = {
    "moon-8": "moon",
    "mars-8": "mars",
    "triangle-8 · Moon": "moon",
    "triangle-8 · Glass on glass": "glass",
}


@pytest.mark.parametrize("draw", DRAWN.values(), ids=DRAWN)
def test_every_picture_of_a_board_shows_its_world(draw: Draw) -> None:
    """By its preset, or by the gravity or material that boards of 1.0 name."""
    names = WORLDS if draw is png else ("moon-8", "triangle-8 · Glass on glass")
    for name in names:
        world = WORLDS[name]
        drawn = draw(Board.preset("triangle-8").replace(name=name))
        assert min(shares(drawn, f"light · {world}", ("rail", "shoulder"))) > 0.01
        assert max(shares(drawn, "light", ("board", "shoulder"))) == 0.0


@pytest.mark.parametrize("draw", CHARTS.values(), ids=CHARTS)
def test_a_chart_has_the_colours_of_its_board_s_world(draw: Draw) -> None:
    board = Board.preset("triangle-8").replace(name="triangle-8 · Moon")
    assert shares(draw(board), "light · moon", ("tray",))[0] > 0.2
    assert shares(draw(board), "light", ("tray",))[0] == 0.0
