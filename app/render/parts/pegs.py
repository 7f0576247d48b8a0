"""Paint pegs in the page's appearance: shadow, light, and the marks of their material."""

import numpy as np

from plinko.app.render.parts.view import View
from plinko.app.render.raster.canvas import Array, Canvas, Gradient, covered
from plinko.app.render.theme import Theme
from plinko.engine import Board
from plinko.engine.json_text import JsonObject

Peg = tuple[float, float, float]
"""x, y and radius, px."""


def paint_pegs(canvas: Canvas, board: Board, view: View, theme: Theme) -> None:
    shadow = theme.shapes["peg"]["shadow"]
    places = [(view.px(p.x), view.py(p.y), max(p.radius * view.scale, 0.5)) for p in board.pegs]
    for x, y, radius in places:
        centre = (x + shadow["across"] * radius, y + shadow["down"] * radius)
        canvas.disc(*centre, radius, theme["shadow"], shadow["alpha"])
    lit = light_of(theme)
    for peg in places:
        paint_peg(canvas, peg, theme, lit)


def paint_peg(canvas: Canvas, peg: Peg, theme: Theme, lit: Gradient) -> None:
    """Paint one peg with its marks, without its shadow."""
    canvas.ball(*peg, lit)
    for mark in theme.shapes["peg"].get("mark", ()):
        _paint_mark(canvas, peg, mark, theme)


def light_of(theme: Theme) -> Gradient:
    shape = theme.shapes["peg"]
    stops = [(stop["at"], *theme[stop["colour"]], 1.0) for stop in shape["shade"]]
    return Gradient(shape["highlight"], stops)


def _paint_mark(canvas: Canvas, peg: Peg, mark: JsonObject, theme: Theme) -> None:
    """Paint one mark on a peg; its measures are parts of the peg's radius."""
    x, y, radius = peg
    colour, alpha, at = theme[mark["colour"]], mark["alpha"], mark["at"]
    if mark["shape"] == "disc":
        canvas.disc(x + at[0] * radius, y + at[1] * radius, at[2] * radius, colour, alpha)
    elif mark["shape"] == "line":
        ends = (x + at[0] * radius, y + at[1] * radius, x + at[2] * radius, y + at[3] * radius)
        canvas.line(ends, at[4] * radius, colour, alpha)
    else:
        patch = canvas.patch(x - radius, y - radius, x + radius, y + radius)
        if patch is not None:
            left, top, xs, ys = patch
            canvas.blend(left, top, _depth(xs - x, ys - y, radius, mark), colour, alpha)


def _depth(dx: Array, dy: Array, radius: float, mark: JsonObject) -> Array:
    """Coverage by a ring around a peg's centre, or by a stripe across the peg."""
    away, at = np.hypot(dx, dy), mark["at"]
    if mark["shape"] == "ring":
        return covered(0.5 * at[1] * radius - abs(away - at[0] * radius))
    below, above = dy - at[0] * radius, (at[0] + at[1]) * radius - dy
    return covered(np.minimum(np.minimum(below, above), radius - away))
