"""A board as SVG text: pegs, walls and bins, in the text colour of the page that shows it."""

from collections.abc import Iterable
from typing import Final

from plinko.engine.board.fields import BoardFields

WIDTH: Final = 380
"""Displayed width in px."""

SCALE: Final = 100.0
"""SVG units per metre on a board of a usual width; coordinates are rounded to tenths of a unit."""

USUAL_WIDTHS: Final = 6.0, 8.0
"""m. Narrower and wider boards are drawn as wide as the nearest of these, with the same strokes."""

ACCENT: Final = "#d9480f"


class Pen:
    """Writes lengths and shapes of a board, given in m, in SVG units."""

    def __init__(self, board: BoardFields) -> None:
        x_min, x_max, _, _ = board.extent
        usual = min(max(x_max - x_min, USUAL_WIDTHS[0]), USUAL_WIDTHS[1])
        self._scale = SCALE * usual / (x_max - x_min)

    def length(self, metres: float) -> str:
        """The shortest text of a length or coordinate."""
        return repr(round(metres * self._scale, 1) + 0.0).removesuffix(".0")

    def disc(self, x: float, y: float, radius: float) -> str:
        """The SVG path of a disc: two half circles that begin at its leftmost point."""
        r, across = self.length(radius), self.length(2.0 * radius)
        start = f"M{self.length(x - radius)} {self.length(y)}"
        return f"{start}a{r} {r} 0 1 1 {across} 0a{r} {r} 0 1 1 -{across} 0"


def board_svg(board: BoardFields, over: Iterable[str] = ()) -> str:
    """The board with the SVG elements `over` drawn on top, which its `Pen` has written."""
    pen = Pen(board)
    length = pen.length
    x_min, x_max, y_min, y_max = board.extent
    corner = f"{length(x_min)} {length(y_min)}"
    size = f"{length(x_max - x_min)} {length(y_max - y_min)}"
    pegs = "".join(pen.disc(peg.x, peg.y, peg.radius) for peg in board.pegs)
    parts = (
        f'<path d="{pegs}" fill-opacity=".45"/>',
        f'<path d="{_walls(board, pen)}" fill="none" stroke="currentColor" stroke-width="2"/>',
        f'<path d="{_bins(board, pen)}" fill="none" stroke="currentColor" stroke-opacity=".45"/>',
        *over,
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{corner} {size}" width="{WIDTH}" '
        f'fill="currentColor" role="img">{"".join(parts)}</svg>'
    )


def _walls(board: BoardFields, pen: Pen) -> str:
    length = pen.length
    return "".join(
        f"M{length(wall.x1)} {length(wall.y1)}L{length(wall.x2)} {length(wall.y2)}"
        for wall in board.walls
    )


def _bins(board: BoardFields, pen: Pen) -> str:
    """The line on which drops end, with a tick at each bin edge."""
    length, bins, tick = pen.length, board.bins, board.ball.radius
    ticks = "".join(f"M{length(x)} {length(bins.y)}v{length(tick)}" for x in bins.edges)
    return f"M{length(bins.edges[0])} {length(bins.y)}H{length(bins.edges[-1])}{ticks}"
