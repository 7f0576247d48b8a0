"""Drops as SVG text: the path of one over its board, and the histogram of a batch."""

from collections.abc import Sequence
from typing import Final

from plinko.engine.board.drawing import ACCENT, WIDTH, Pen, board_svg
from plinko.engine.board.fields import BoardFields
from plinko.engine.physics.array_types import Floats

MOMENTS: Final = 400
"""Points of a path that are drawn, in addition to those of its events."""

_HEIGHT: Final = 160.0  # height of a histogram's tallest column, in SVG units
_NUMBERS: Final = 14.0  # height of the bins' numbers below the columns


def path_svg(board: BoardFields, xs: Floats, ys: Floats) -> str:
    """The board with the path of a ball's centre through `xs` and `ys`, shape (n,) in m."""
    pen = Pen(board)
    points = " ".join(
        f"{pen.length(x)},{pen.length(y)}" for x, y in zip(xs.tolist(), ys.tolist(), strict=True)
    )
    ball = pen.disc(float(xs[-1]), float(ys[-1]), board.ball.radius)
    return board_svg(
        board,
        (
            f'<polyline points="{points}" fill="none" stroke="{ACCENT}" stroke-width="2.5"/>',
            f'<path d="{ball}" fill="{ACCENT}"/>',
        ),
    )


def histogram_svg(counts: Sequence[int]) -> str:
    """A column for each bin, with the bin's number below it and its count as a tooltip."""
    pitch = WIDTH / len(counts)
    top = max(*counts, 1)
    columns = "".join(
        _column(i, count, i * pitch, pitch, _HEIGHT * count / top) for i, count in enumerate(counts)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {_HEIGHT + _NUMBERS:g}" '
        f'width="{WIDTH}" fill="currentColor" role="img">{columns}</svg>'
    )


def _column(number: int, count: int, left: float, pitch: float, height: float) -> str:
    box = (
        f'<rect x="{left + 0.05 * pitch:.1f}" y="{_HEIGHT - height:.1f}" '
        f'width="{0.9 * pitch:.1f}" height="{height:.1f}" fill="{ACCENT}">'
        f"<title>bin {number}: {count:,}</title></rect>"
    )
    if pitch < 10.0:  # px: no room for a number
        return box
    place = f'x="{left + 0.5 * pitch:.1f}" y="{_HEIGHT + 0.8 * _NUMBERS:.1f}"'
    return f'{box}<text {place} font-size="9" text-anchor="middle">{number}</text>'
