"""A board as SVG text: pegs, walls and bins, in the text colour of the page that shows it."""

from collections.abc import Iterable
from typing import Final

from engine.board.fields import BoardFields

WIDTH: Final = 380
"""Displayed width in px."""

SCALE: Final = 100.0
"""SVG units per metre; coordinates are rounded to tenths of a unit."""

ACCENT: Final = "#d9480f"


def board_svg(board: BoardFields, over: Iterable[str] = ()) -> str:
    """The board with the SVG elements `over` drawn on top, all in SCALE units per metre."""
    x_min, x_max, y_min, y_max = board.extent
    corner = f"{length(x_min)} {length(y_min)}"
    size = f"{length(x_max - x_min)} {length(y_max - y_min)}"
    pegs = "".join(disc(peg.x, peg.y, peg.radius) for peg in board.pegs)
    parts = (
        f'<path d="{pegs}" fill-opacity=".45"/>',
        f'<path d="{_walls(board)}" fill="none" stroke="currentColor" stroke-width="2"/>',
        f'<path d="{_bins(board)}" fill="none" stroke="currentColor" stroke-opacity=".45"/>',
        *over,
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{corner} {size}" width="{WIDTH}" '
        f'fill="currentColor" role="img">{"".join(parts)}</svg>'
    )


def length(metres: float) -> str:
    """The shortest text of a length or coordinate, converted from m to SVG units."""
    return repr(round(metres * SCALE, 1) + 0.0).removesuffix(".0")


def disc(x: float, y: float, radius: float) -> str:
    """The SVG path of a disc, given in m: two half circles that begin at its leftmost point."""
    r, across = length(radius), length(2.0 * radius)
    start = f"M{length(x - radius)} {length(y)}"
    return f"{start}a{r} {r} 0 1 1 {across} 0a{r} {r} 0 1 1 -{across} 0"


def _walls(board: BoardFields) -> str:
    return "".join(
        f"M{length(wall.x1)} {length(wall.y1)}L{length(wall.x2)} {length(wall.y2)}"
        for wall in board.walls
    )


def _bins(board: BoardFields) -> str:
    """The line on which drops end, with a tick at each bin edge."""
    bins, tick = board.bins, board.ball.radius
    ticks = "".join(f"M{length(x)} {length(bins.y)}v{length(tick)}" for x in bins.edges)
    return f"M{length(bins.edges[0])} {length(bins.y)}H{length(bins.edges[-1])}{ticks}"
