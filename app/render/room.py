"""Frames of a room: moving balls, painted onto a fixed layer that is drawn only once."""

import math
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.parts import balls
from plinko.app.render.parts.board import board_pixels, paint_bin
from plinko.app.render.parts.caption import paint_strip, paint_words
from plinko.app.render.parts.view import View, lay_out
from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.raster.palette import Palette, Pixels
from plinko.app.render.still import DEFAULT_WIDTH
from plinko.app.render.theme import at_place, named
from plinko.engine import Board
from plinko.engine.physics.array_types import Floats

_NO_TRAILS: Final[Mapping[int, Floats]] = {}


class Layer:
    """Frames of one place in one size and theme, all from one layer. For one thread at a time.

    bare: the layer without words, pixels (h, w, 3). radius: of balls whose radius `frame` does not
    get, in m. title: the words in the strip above.
    """

    def __init__(self, view: View, bare: Pixels, radius: float, theme: str, title: str) -> None:
        self.view = view
        self.theme = theme
        self.title = title
        self._radius = radius
        self._style = balls.style_of(radius * view.scale, theme)
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
        """Paint the balls of `bodies`; returns new RGB pixels (h, w, 3).

        bodies: shape (n,), with the fields id, x, y (m) and theta (rad) of `World.bodies`, and
        optionally radius (m) and asleep of `Arena.bodies`; sleeping balls are grey. trails:
        positions of a ball by its id, shape (m, 2), in m, newest first. lit: bins hit recently.
        facts: the words below the title, the most important first.
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
                balls.paint_trail(pixels, np.column_stack([x, y]), self._style, view.face)
        if "radius" in (bodies.dtype.names or ()):
            self._paint_sizes(pixels, bodies)
        else:
            self._paint(pixels, bodies, self._style, None)
        return pixels

    def _paint_sizes(self, pixels: Pixels, bodies: npt.NDArray[np.void]) -> None:
        """Paint balls of several sizes, with the gloss of the largest; sleeping balls first."""
        radii = np.maximum(bodies["radius"] * self.view.scale, balls.LEAST_RADIUS)
        for asleep in (True, False):
            chosen = (bodies["asleep"] != 0) == asleep
            if chosen.any():
                largest = _stepped(float(radii[chosen].max()))
                style = balls.style_of(largest, self.theme, asleep=asleep)
                self._paint(pixels, bodies[chosen], style, radii[chosen])

    def _paint(
        self,
        pixels: Pixels,
        bodies: npt.NDArray[np.void],
        style: balls.Style,
        radii: Floats | None,
    ) -> None:
        view = self.view
        xs, ys = view.px(bodies["x"]), view.py(bodies["y"])
        balls.paint_balls(pixels, xs, ys, bodies["theta"], style, view.face, radii)

    def jpg(self, pixels: Pixels) -> bytes:
        """Encode a frame as JPEG, quickly."""
        return encode.live_jpg(pixels)

    def png(self, pixels: Pixels) -> bytes:
        """Encode a frame as PNG, quickly, with the palette that all frames of this stage share."""
        return encode.live_png(pixels, self._palette)

    def _write(self, facts: tuple[str, ...]) -> None:
        rows = math.ceil(self.view.header)
        strip = Canvas(self._bare[:rows].astype(np.float32))
        theme = named(self.theme)
        room = paint_strip(strip, self.view, theme)
        paint_words(strip, self.view, theme, self.title, [*facts], room)
        self._layer[:rows] = strip.bytes()
        self._strip = facts

    def _lit_bin(self, number: int) -> tuple[slice, slice, Pixels]:
        """The rows, columns and pixels of a lit bin."""
        raise LookupError(f"there is no bin {number} to light")

    @cached_property
    def _palette(self) -> Palette:
        """The colours of the layer and of everything that a frame can add to it."""
        return Palette([self._layer, self._crowded()])

    def _crowded(self) -> Pixels:
        """A frame that contains all colours: balls in many places."""
        raise NotImplementedError


def _stepped(radius: float) -> float:
    """Round a radius in px up to a power of sqrt(2), so that few different glosses are needed."""
    return float(2.0 ** (math.ceil(2.0 * math.log2(radius)) / 2.0))


class Stage(Layer):
    """Frames of one board in one size and theme, all from one layer. For one thread at a time.

    `width` in px, 240 to 2048. `title` is written in the strip above the board. Raises
    InvalidValueError if the width or theme is invalid.
    """

    def __init__(
        self,
        board: Board,
        width: int = DEFAULT_WIDTH,
        theme: str = "light",
        title: str | None = None,
    ) -> None:
        view, theme = lay_out(board, width), at_place(theme, board.name)
        name = board.name if title is None else title
        super().__init__(view, board_pixels(board, view, theme), board.ball.radius, theme, name)
        self.board = board
        self._lit: dict[int, tuple[slice, slice, Pixels]] = {}

    def _lit_bin(self, number: int) -> tuple[slice, slice, Pixels]:
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
        """A frame with balls and trails in many places, and all bins lit."""
        view, board = self.view, self.board
        rows, columns = (np.linspace(0.04, 0.96, count) for count in (12, 16))
        x = view.left + np.repeat(columns[None], len(rows), axis=0) * view.width / view.scale
        y = board.drop.y + np.repeat(rows[:, None], len(columns), axis=1) * (
            board.bins.y - board.drop.y
        )
        bodies = np.zeros(x.size, [("id", "i4"), ("x", "f8"), ("y", "f8"), ("theta", "f8")])
        bodies["id"], bodies["x"], bodies["y"] = np.arange(x.size), x.ravel(), y.ravel()
        bodies["theta"] = 0.37 * np.arange(x.size)
        above = np.array([[0.0, 0.0], [0.0, -4.0 * board.ball.radius]])
        trails = {n: np.array([x.flat[n], y.flat[n]]) + above for n in range(x.size)}
        return self.frame(bodies, trails=trails, lit=range(board.bins.count))
