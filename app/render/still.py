"""Draw a drop as a still picture: the board, the path, the contacts and the result."""

import math
from typing import Final

import numpy as np

from plinko.app.errors import InvalidValueError
from plinko.app.render.parts import balls
from plinko.app.render.parts.board import board_pixels, paint_bin
from plinko.app.render.parts.caption import paint_caption
from plinko.app.render.parts.path import paint_contacts, paint_ghosts, paint_path
from plinko.app.render.parts.view import View, lay_out
from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.raster.palette import Pixels
from plinko.app.render.theme import Scheme, at_place, named
from plinko.engine import Drop

DEFAULT_WIDTH: Final = 760  # px, the reference game's canvas


def drop_picture(
    d: Drop,
    fmt: encode.Still = "png",
    width: int = DEFAULT_WIDTH,
    theme: Scheme = "light",
    at: float | None = None,
) -> bytes:
    """Draw the drop in `fmt`: `png`, `jpg` or `webp`.

    `width` in px, 240 to 2048; `theme` is `light` or `dark`. With `at`, in s after the start, the
    picture shows that moment, with the path and contacts up to it. Raises InvalidValueError if an
    argument is invalid.
    """
    if at is not None and not (math.isfinite(at) and at >= 0.0):
        raise InvalidValueError(f"t {at!r} must be a number of seconds, at least 0", field="t")
    placed = at_place(theme, d.board.name)
    return encode.still(drop_pixels(d, lay_out(d.board, width), placed, at), fmt)


def drop_pixels(d: Drop, view: View, theme_name: str, at: float | None = None) -> Pixels:
    """The pixels of a drop, shape (h, w, 3), at `at` s or, without it, at the end."""
    theme = named(theme_name)
    ended = at is None or at >= d.duration
    until = d.duration if at is None or ended else at
    pixels = board_pixels(d.board, view, theme_name).copy()
    if ended and d.bin is not None:
        top = max(int(view.bin_top - 4.0 * view.unit), 0)
        part = Canvas(pixels[top:].astype(np.float32))
        inside = view.cut(0, top, part.width, part.height)
        paint_bin(part, d.board, inside, theme, d.bin, lit=True)
        pixels[top:] = part.bytes()
    if until > 0.0:
        paint_ghosts(pixels, d, view, theme, until)
        paint_path(pixels, d, view, theme, until)
        paint_contacts(pixels, d, view, theme, until)
    if view.header:
        strip = pixels[: math.ceil(view.header)]
        words = Canvas(strip.astype(np.float32))
        paint_caption(words, d, view, theme, None if ended else until)
        strip[:] = words.bytes()
    _paint_balls(pixels, d, view, theme_name, until)
    return pixels


def _paint_balls(pixels: Pixels, d: Drop, view: View, theme_name: str, until: float) -> None:
    """Paint the ball at its start and at the time `until`."""
    states = d.states([0.0, until])
    style = balls.style_of(d.board.ball.radius * view.scale, theme_name)
    # Paint it in front of the bins' faces, unlike in animations, so that the end stays visible.
    lowest = pixels.shape[0]
    xs, ys = (np.asarray(view.px(states["x"])), np.asarray(view.py(states["y"])))
    balls.paint_balls(pixels, xs, ys, states["theta"], style, lowest)
