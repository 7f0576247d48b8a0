"""A board in motion: frames of its balls, painted onto a layer that is made once."""

import math
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from app.render.parts import balls
from app.render.parts.board import board_pixels, paint_bin
from app.render.parts.caption import paint_strip, paint_words
from app.render.parts.view import View, lay_out
from app.render.raster import encode
from app.render.raster.canvas import Canvas
from app.render.raster.palette import Palette
from app.render.still import DEFAULT_WIDTH
from app.render.theme import named
from engine import Board

Pixels = npt.NDArray[np.uint8]
Floats = npt.NDArray[np.float64]

_NO_TRAILS: Final[Mapping[int, Floats]] = {}


class Layer:
    """Frames of one place in one size and theme, all from one layer; for one thread at a time.

    bare: the layer without words, pixels (h, w, 3). radius: of a ball of which nothing else is
    said, m. title: what stands in the strip above.
    """

    def __init__(
        self, view: View, bare: npt.NDArray[np.uint8], radius: float, theme: str, title: str
    ) -> None:
        self.view = view
        self.theme = theme
        self.title = title
        self._radius = radius
        self._look = balls.look_of(radius * view.scale, theme)
        self._strip: tuple[str, ...] | None = None
        self._bare = bare
        self._layer = bare.copy()
        self._write(())

    def frame(
        self,
        bodies: npt.NDArray[np.void],
        *,
        trails: Mapping[int, Floats] = _NO_TRAILS,
        lit: Collection[int] = (),
        facts: Sequence[str] = (),
    ) -> Pixels:
        """The balls where `bodies` says, as pixels (h, w, 3), RGB; the array is the caller's.

        bodies: shape (n,), with fields id, x, y (m) and theta (rad), as `World.bodies` has them;
        with radius (m) and asleep, if there are these, as `Arena.bodies` has them: who sleeps is
        grey. trails: by ball, where it is and was, shape (m, 2), m, newest first. lit: bins just
        hit. facts: what stands below the title, the most telling first.
        """
        if tuple(facts) != self._strip:
            self._write(tuple(facts))
        pixels = self._layer.copy()
        for number in lit:
            rows, columns, face = self._lit_bin(number)
            pixels[rows, columns] = face
        view = self.view
        for number in bodies["id"].tolist() if trails else ():
            points = trails.get(number)
            if points is not None and len(points) > 1:
                x, y = view.px(points[:, 0]), view.py(points[:, 1])
                balls.paint_trail(pixels, np.column_stack([x, y]), self._look, view.face)
        if "radius" in (bodies.dtype.names or ()):
            self._paint_sizes(pixels, bodies)
        else:
            self._paint(pixels, bodies, self._look, None)
        return pixels

    def _paint_sizes(self, pixels: Pixels, bodies: npt.NDArray[np.void]) -> None:
        """Balls of many sizes, with the gloss of the largest; first those that sleep."""
        radii = np.maximum(bodies["radius"] * self.view.scale, balls.LEAST_RADIUS)
        for asleep in (True, False):
            chosen = (bodies["asleep"] != 0) == asleep
            if chosen.any():
                largest = _stepped(float(radii[chosen].max()))
                look = balls.look_of(largest, self.theme, asleep=asleep)
                self._paint(pixels, bodies[chosen], look, radii[chosen])

    def _paint(
        self,
        pixels: Pixels,
        bodies: npt.NDArray[np.void],
        look: balls.Look,
        radii: Floats | None,
    ) -> None:
        view = self.view
        xs, ys = view.px(bodies["x"]), view.py(bodies["y"])
        balls.paint_balls(pixels, xs, ys, bodies["theta"], look, view.face, radii)

    def jpg(self, pixels: Pixels) -> bytes:
        """A frame as JPEG, fast."""
        return encode.live_jpg(pixels)

    def png(self, pixels: Pixels) -> bytes:
        """A frame as PNG, fast, in a palette that all frames of this stage share."""
        return encode.live_png(pixels, self._palette)

    def _write(self, facts: tuple[str, ...]) -> None:
        """Write title and facts into the layer's strip."""
        rows = math.ceil(self.view.header)
        strip = Canvas(self._bare[:rows].astype(np.float32))
        theme = named(self.theme)
        room = paint_strip(strip, self.view, theme)
        paint_words(strip, self.view, theme, self.title, [*facts], room)
        self._layer[:rows] = strip.bytes()
        self._strip = facts

    def _lit_bin(self, number: int) -> tuple[slice, slice, Pixels]:
        """Where a bin with a light around it is on the layer, and what it looks like."""
        raise LookupError(f"there is no bin {number} to light")

    @cached_property
    def _palette(self) -> Palette:
        """The colours of the layer, and of all that a frame can add to it."""
        return Palette([self._layer, self._crowded()])

    def _crowded(self) -> Pixels:
        """A frame with balls in many places."""
        raise NotImplementedError


def _stepped(radius: float) -> float:
    """A radius in px rounded up to one of few, so that not every frame needs a gloss of its own."""
    return float(2.0 ** (math.ceil(2.0 * math.log2(radius)) / 2.0))


class Stage(Layer):
    """Frames of one board in one size and theme, all from one layer; for one thread at a time.

    `width` in px, 240 to 2048. With a `height` the board fits into both. `title` stands in the
    strip above the board. Raises InvalidValueError naming a size or a theme that is none.
    """

    def __init__(
        self,
        board: Board,
        width: int = DEFAULT_WIDTH,
        height: int | None = None,
        theme: str = "light",
        title: str | None = None,
    ) -> None:
        view = lay_out(board, width, height)
        name = board.name if title is None else title
        super().__init__(view, board_pixels(board, view, theme), board.ball.radius, theme, name)
        self.board = board
        self._lit: dict[int, tuple[slice, slice, Pixels]] = {}

    def _lit_bin(self, number: int) -> tuple[slice, slice, Pixels]:
        """Where a bin with a light around it is on the layer, and what it looks like."""
        if number not in self._lit:
            view, edges = self.view, self.board.bins.edges
            left = max(int(view.px(edges[number]) - 4.0 * view.unit), 0)
            right = math.ceil(view.px(edges[number + 1]) + 4.0 * view.unit)
            top = max(int(view.bin_top - 4.0), 0)
            part = Canvas(self._layer[top:, left:right].astype(np.float32))
            inside = view.cut(left, top, part.width, part.height)
            paint_bin(part, self.board, inside, named(self.theme), number, lit=True)
            self._lit[number] = slice(top, None), slice(left, right), part.bytes()
        return self._lit[number]

    def _crowded(self) -> Pixels:
        """Balls with trails in many places, and all bins lit."""
        view, board = self.view, self.board
        rows, columns = (np.linspace(0.04, 0.96, count) for count in (12, 16))
        x = view.left + np.repeat(columns[None], len(rows), axis=0) * view.width / view.scale
        y = board.drop.y + np.repeat(rows[:, None], len(columns), axis=1) * (
            board.bins.y - board.drop.y
        )
        bodies = scattered(x.ravel(), y.ravel())
        above = np.array([[0.0, 0.0], [0.0, -4.0 * board.ball.radius]])
        trails = {n: np.array([x.flat[n], y.flat[n]]) + above for n in range(x.size)}
        return self.frame(bodies, trails=trails, lit=range(board.bins.count))


def scattered(xs: Floats, ys: Floats) -> npt.NDArray[np.void]:
    """Bodies at these places, m, each turned otherwise."""
    bodies = np.zeros(xs.size, [("id", "i4"), ("x", "f8"), ("y", "f8"), ("theta", "f8")])
    bodies["id"], bodies["x"], bodies["y"] = np.arange(xs.size), xs, ys
    bodies["theta"] = 0.37 * np.arange(xs.size)
    return bodies
