"""Frames of a box with balls in it, in the appearance of the sandbox page."""

import functools
import math
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.parts.view import View, check_width, lay_out_place
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.raster.palette import Pixels
from plinko.app.render.room import Layer
from plinko.app.render.still import DEFAULT_WIDTH
from plinko.app.render.theme import Theme, named
from plinko.engine.multibody.bodies import ARENA_BODY
from plinko.engine.multibody.static_geometry import StaticGeometry

_SAMPLE: Final = 12  # balls side by side in the picture from which the palette is made


class BoxStage(Layer):
    """Frames of one place in one size and theme. For one thread at a time.

    `width` in px, 240 to 2048; the height follows from the place. radius: of a typical ball, in m.
    Raises InvalidValueError if the size or theme is invalid.
    """

    def __init__(
        self,
        place: StaticGeometry,
        width: int = DEFAULT_WIDTH,
        theme: str = "light",
        title: str = "",
        radius: float = 0.1,
    ) -> None:
        check_width(width)
        view = lay_out_place(place, width, named(theme))
        super().__init__(view, place_pixels(place, view, theme), radius, theme, title)
        self.place = place

    def _crowded(self) -> Pixels:
        """A frame with balls of several sizes everywhere, every third of them asleep."""
        x0, x1, y0, y1 = self.place.extent
        xs, ys = np.meshgrid(np.linspace(x0, x1, _SAMPLE), np.linspace(y0, y1, _SAMPLE))
        bodies = np.zeros(xs.size, ARENA_BODY)
        bodies["x"], bodies["y"] = xs.ravel(), ys.ravel()
        bodies["theta"] = 0.37 * np.arange(xs.size)
        bodies["radius"] = self._radius * (0.6 + 0.2 * (np.arange(xs.size) % 5))
        bodies["asleep"] = np.arange(xs.size) % 3 == 0
        return self.frame(bodies)


@functools.lru_cache(maxsize=3)  # in the largest size 12 MB each
def place_pixels(place: StaticGeometry, view: View, theme_name: str) -> npt.NDArray[np.uint8]:
    """The fixed part of the picture, shape (h, w, 3); cached and shared, therefore read-only."""
    theme = named(theme_name)
    canvas = Canvas.blank(view.width, view.height, theme["board"])
    _ground(canvas, place, view, theme)
    _walls(canvas, place, view, theme)
    for peg in place.pegs:
        canvas.disc(view.px(peg.x), view.py(peg.y), peg.radius * view.scale, theme["peg"])
    _bins(canvas, place, view, theme)
    pixels = canvas.bytes()
    pixels.flags.writeable = False
    return pixels


def _ground(canvas: Canvas, place: StaticGeometry, view: View, theme: Theme) -> None:
    """Enamel with a grid of metres, by which viewers can judge speeds and sizes."""
    top, bottom = (np.asarray(theme[name], dtype=np.float32) for name in ("board", "boardDeep"))
    fade = np.linspace(0.0, 1.0, view.height, dtype=np.float32)[:, None, None]
    canvas.pixels[:] = top + fade * (bottom - top)
    x0, x1, y0, y1 = place.extent
    left, right, upper, lower = view.px(x0), view.px(x1), view.py(y0), view.py(y1)
    half = 0.5 * view.unit
    for x in range(math.ceil(x0), math.floor(x1) + 1):
        at = view.px(float(x))
        canvas.box((at - half, upper, at + half, lower), 0.0, theme["ray"])
    for y in range(math.ceil(y0), math.floor(y1) + 1):
        at = view.py(float(y))
        canvas.box((left, at - half, right, at + half), 0.0, theme["ray"])


def _walls(canvas: Canvas, place: StaticGeometry, view: View, theme: Theme) -> None:
    """Paint walls, which have no thickness: on the rim outside, so that balls touch their edge."""
    shape = theme.shapes["box"]
    least, most = shape["least"] * view.unit, shape["most"] * view.unit
    width = max(least, min(most, shape["metres"] * view.scale))
    x0, x1, y0, y1 = place.extent
    for wall in place.walls:
        dx = 0.5 * width * _outwards(wall.x1, wall.x2, x0, x1)
        dy = 0.5 * width * _outwards(wall.y1, wall.y2, y0, y1)
        ends = (
            view.px(wall.x1) + dx,
            view.py(wall.y1) + dy,
            view.px(wall.x2) + dx,
            view.py(wall.y2) + dy,
        )
        canvas.line(ends, width, theme["rail"])


def _outwards(one: float, other: float, low: float, high: float) -> int:
    """-1 for a wall at the lower end of an axis, 1 at the upper end, 0 elsewhere."""
    if one != other or low == high:
        return 0
    return (one == high) - (one == low)


def _bins(canvas: Canvas, place: StaticGeometry, view: View, theme: Theme) -> None:
    if place.bins is None:
        return
    y, edges, unit = view.py(place.bins.y), place.bins.edges, view.unit
    line = (view.px(edges[0]), y - unit, view.px(edges[-1]), y + unit)
    canvas.box(line, 0.0, theme["trayMark"])
    for edge in edges:
        x = view.px(edge)
        canvas.box((x - unit, y - 8.0 * unit, x + unit, y), 0.0, theme["trayMark"])
