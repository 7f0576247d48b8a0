"""Paint the fixed board: plate, rays, pegs, bins, rails. It is cached, as every frame needs it."""

import functools
import itertools
import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from plinko.app.render.parts import ground
from plinko.app.render.parts.prizes import LINE_HEIGHT, Lettering, lettering, style_of, tight
from plinko.app.render.parts.view import View
from plinko.app.render.raster.canvas import (
    Array,
    Canvas,
    Gradient,
    covered,
    polygon_coverage,
    text_width,
)
from plinko.app.render.theme import Colour, Theme, named
from plinko.engine import Board
from plinko.engine.json_text import JsonObject

Point = tuple[float, float]

LEAST_LABEL = 4.0  # px; smaller letters are illegible and not written


@functools.lru_cache(maxsize=3)  # in the largest size 12 MB each
def board_pixels(board: Board, view: View, theme_name: str) -> npt.NDArray[np.uint8]:
    """The board, shape (h, w, 3); cached and shared, therefore read-only."""
    canvas = plate_canvas(board, view, theme_name)
    paint_furniture(canvas, board, view, named(theme_name))
    pixels = canvas.bytes()
    pixels.flags.writeable = False
    return pixels


def plate_canvas(board: Board, view: View, theme_name: str) -> Canvas:
    """A canvas with the plate and the hopper, but without pegs, bins and rails."""
    theme = named(theme_name)
    canvas = Canvas.blank(view.width, view.height, theme["shoulder"])
    _plate(canvas, board, view, theme)
    _hopper(canvas, board, view, theme)
    return canvas


def paint_furniture(canvas: Canvas, board: Board, view: View, theme: Theme) -> None:
    """Paint pegs, bins and rails."""
    paint_pegs(canvas, board, view, theme)
    for number in range(board.bins.count):
        paint_bin(canvas, board, view, theme, number)
    _rails(canvas, board, view, theme)


def paint_bin(
    canvas: Canvas, board: Board, view: View, theme: Theme, number: int, lit: bool = False
) -> None:
    """Paint one bin with its label or multiplier; `lit` after a landing."""
    bins = board.bins
    fill, ink = style_of(board, number, theme)
    x0, x1 = view.px(bins.edges[number]), view.px(bins.edges[number + 1])
    gap = max(1.0 * view.unit, min(3.0 * view.unit, 0.06 * (x1 - x0)))
    box = (x0 + gap, view.bin_top + 2 * view.unit, x1 - gap, view.bin_top + view.bin_height - 2)
    radius = min(8.0 * view.unit, 0.22 * (x1 - x0 - 2 * gap))
    if lit:
        rim = 3.0 * view.unit
        outer = (box[0] - rim, box[1] - rim, box[2] + rim, box[3] + rim)
        canvas.box(outer, radius + rim, theme["flash"])
    canvas.box(box, radius, fill)
    middle = (0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3]))
    if bins.labels:
        letters = lettering(board, view)[number]
    else:
        letters = Lettering((tight(bins.multipliers[number]),), *_label_size(board, view))
    if letters.size >= LEAST_LABEL:
        _write(canvas, middle, letters, ink)


def _write(canvas: Canvas, middle: Point, letters: Lettering, ink: Colour) -> None:
    x, y = middle
    for number, line in enumerate(letters.lines):
        away = (number - 0.5 * (len(letters.lines) - 1)) * LINE_HEIGHT * letters.size
        at = (x + away, y) if letters.upright else (x, y + away)
        canvas.text(*at, line, letters.size, ink, upright=letters.upright)


@functools.lru_cache(maxsize=4)
def _label_size(board: Board, view: View) -> tuple[float, bool]:
    """The size in px of all multipliers, and whether they are upright.

    They are upright if the bins are too narrow for legible letters across.
    """
    edges = board.bins.edges
    width = 0.84 * view.scale * min(b - a for a, b in itertools.pairwise(edges))
    height = view.bin_height - 4.0 * view.unit
    longest = max(text_width(tight(value), 100.0) for value in board.bins.multipliers) / 100.0
    size = min(width / longest, 0.5 * height, 24.0 * view.unit)
    if size >= 9.0 * view.unit:
        return size, False
    return min(width, 0.86 * height / longest, 20.0 * view.unit), True


def _plate(canvas: Canvas, board: Board, view: View, theme: Theme) -> None:
    """Paint enamel between the walls, darker shoulders outside, and the printed pattern on both."""
    width, height = view.width, view.height
    field = polygon_coverage([_field(board, view)], width, height)
    fade = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None, None]
    top, bottom = (np.asarray(theme[name], dtype=np.float32) for name in ("board", "boardDeep"))
    enamel = np.broadcast_to(top + fade * (bottom - top), (height, width, 3))
    if theme.ground == "rays":
        rays = polygon_coverage(_rays(board, view, theme.shapes["rays"]), width, height)
        canvas.blend(0, 0, rays, theme["shoulderRay"])
        canvas.blend(0, 0, field, enamel)
        canvas.blend(0, 0, field * rays, theme["ray"], 0.6)
        return
    below = round(view.header)  # the strip with words will cover the rows above
    place = ground.Place(view.px(board.drop.x), view.unit, theme)
    ground.paint_surroundings(Canvas(canvas.pixels[below:]), place)
    canvas.blend(0, 0, field, enamel)
    ground.paint_plate(Canvas(canvas.pixels[below:], field[below:]), place)


def _field(board: Board, view: View) -> list[Point]:
    """The outline of the area between the side walls, or of the picture without them."""
    width, height = float(view.width), float(view.height)
    sides = {side: _side(board, view, side) for side in (-1, 1)}
    left = sides[-1] or [(0.0, 0.0), (0.0, height)]
    right = sides[1] or [(width, 0.0), (width, height)]
    left = [(left[0][0], 0.0), *left, (left[-1][0], height)]
    right = [(right[0][0], 0.0), *right, (right[-1][0], height)]
    return left + right[::-1]


def _side(board: Board, view: View, side: int) -> list[Point]:
    """The points in px, from top to bottom, along the walls of a side: -1 left, 1 right."""
    points: list[Point] = []
    for wall, at in zip(board.walls, sides_of(board), strict=True):
        if at == side:
            points += _near_picture(
                (view.px(wall.x1), view.py(wall.y1)), (view.px(wall.x2), view.py(wall.y2)), view
            )
    return sorted(points, key=lambda point: point[1])


def _near_picture(start: Point, end: Point, view: View) -> list[Point]:
    """Clip a wall to within one picture's height of the picture, as Pillow needs small integers."""
    low, high = -float(view.height), 2.0 * view.height
    if max(start[1], end[1]) < low or min(start[1], end[1]) > high:
        return []

    def at(y: float) -> Point:
        part = (y - start[1]) / (end[1] - start[1]) if end[1] != start[1] else 0.0
        return start[0] + part * (end[0] - start[0]), y

    return [p if low <= p[1] <= high else at(min(max(p[1], low), high)) for p in (start, end)]


def _rays(board: Board, view: View, count: int) -> list[list[Point]]:
    """The printed sunburst: every other one of `count` wedges around the start of balls."""
    x, y = view.px(board.drop.x), view.start
    reach = float(view.width + view.height)

    def rim(ray: float) -> Point:
        angle = 2.0 * math.pi * ray / count
        return x + reach * math.cos(angle), y + reach * math.sin(angle)

    return [[(x, y), rim(ray + 0.5), rim(ray + 1.5)] for ray in range(0, count, 2)]


def _hopper(canvas: Canvas, board: Board, view: View, theme: Theme) -> None:
    """Paint the slide along which a ball may start, or the numbered slots."""
    radius = max(board.ball.radius * view.scale, 5.0 * view.unit)
    if not board.slots:
        x0, x1 = (view.px(board.drop.x + side * board.drop.span) for side in (-1, 1))
        ends = (x0, view.start, x1, view.start)
        canvas.line(ends, 2.0 * radius + 6.0 * view.unit, theme["railShade"])
        return
    size = max(12.0, min(18.0, 0.2 * view.metre / view.unit)) * view.unit
    for number, slot in enumerate(board.slots, 1):
        x = view.px(slot)
        canvas.disc(x, view.start, radius + 3.0 * view.unit, theme["railShade"])
        above = view.start - radius - 13.0 * view.unit
        canvas.text(x, above, str(number), size, theme["rail"])


def _rails(canvas: Canvas, board: Board, view: View, theme: Theme) -> None:
    """Paint walls as rails. A wall has no thickness: a side's rail lies outside the playing field,
    so that balls touch its edge."""
    shape = theme.shapes["rail"]
    width = max(shape["least"] * view.unit, shape["metres"] * view.metre)
    shade = [length * view.unit for length in shape["shade"]]
    lines = []
    for wall, side in zip(board.walls, sides_of(board), strict=True):
        # A wall may be far longer than the picture; the canvas clips it.
        x1, x2 = (view.px(x) + 0.5 * width * side for x in (wall.x1, wall.x2))
        lines.append((x1, view.py(wall.y1), x2, view.py(wall.y2)))
    for x1, y1, x2, y2 in lines:
        ends = (x1 + shade[0], y1 + shade[1], x2 + shade[0], y2 + shade[1])
        canvas.line(ends, width, theme["railShade"])
    for ends in lines:
        canvas.line(ends, width, theme["rail"])


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


@functools.lru_cache(maxsize=4)
def sides_of(board: Board) -> tuple[int, ...]:
    """For each wall: -1 at the left side, 1 at the right side, 0 inside.

    A side is a chain of walls with common ends that leads down to an outer end of the bins.
    """
    found = [0] * len(board.walls)
    for chain in _chains(board):
        ends = {end for wall in chain if (end := _end_reached(board, wall))}
        for wall in chain:
            if len(ends) == 1:
                (found[wall],) = ends
            elif ends:
                middle = board.walls[wall].x1 + board.walls[wall].x2 - 2.0 * board.drop.x
                found[wall] = (middle > 0.0) - (middle < 0.0)
    return tuple(found)


def _end_reached(board: Board, number: int) -> int:
    """The outer end of the bins (-1 or 1) that a wall reaches within a ball's radius; else 0."""
    wall, bins, near = board.walls[number], board.bins, board.ball.radius
    top, bottom = sorted(((wall.y1, wall.x1), (wall.y2, wall.x2)))
    if not top[0] <= bins.y <= bottom[0] + near:
        return 0
    part = min((bins.y - top[0]) / (bottom[0] - top[0]), 1.0) if bottom[0] > top[0] else 1.0
    x = top[1] + part * (bottom[1] - top[1])
    return (x >= bins.edges[-1] - near) - (x <= bins.edges[0] + near)


def _chains(board: Board) -> Iterator[list[int]]:
    """Yield the chains of walls that share ends, as lists of wall numbers."""
    meeting: dict[Point, list[int]] = {}
    for number, wall in enumerate(board.walls):
        for end in ((wall.x1, wall.y1), (wall.x2, wall.y2)):
            meeting.setdefault(end, []).append(number)
    left = dict.fromkeys(range(len(board.walls)))
    while left:
        chain = [next(iter(left))]
        del left[chain[0]]
        for number in chain:  # the loop appends to the list it iterates over
            wall = board.walls[number]
            for end in ((wall.x1, wall.y1), (wall.x2, wall.y2)):
                for other in meeting[end]:
                    if other in left:
                        del left[other]
                        chain.append(other)
        yield chain
