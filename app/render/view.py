"""Where a board lies on a picture of a given width: metres to pixels, as on the page."""

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from app.errors import InvalidValueError
from engine import Board

Number = TypeVar("Number", float, npt.NDArray[np.float64])

LEAST_WIDTH, MOST_WIDTH = 240, 2048
"""px: in a narrower picture labels cannot be read; a wider one costs memory, not looks."""

PIXELS_PER_METRE: Final = 100
"""Scale at which the sizes below are given: that of the reference game's canvas."""

REFERENCE_WIDTH: Final = 7.6  # m, of that canvas
LEAST_UNIT: Final = 0.6  # of lines and letters in a narrow picture: smaller ones do not print

SIDE_PAD: Final = 0.08  # m, beside the outermost part of the board
HEADER: Final = 60.0  # px, the caption above the board
HEADROOM: Final = 34.0  # px from the caption to where balls start, if no ball is larger
BIN_LEAST, BIN_MOST = 34.0, 84.0  # px, height of the bins
MAX_ASPECT: Final = 2.5
"""Height of the playing field over the picture's width, at most; a taller board is drawn smaller,
so that a picture's memory is bounded by its width whatever the board."""


@dataclass(frozen=True)
class View:
    """A picture's size and its map from metres to pixels."""

    width: int  # px
    height: int  # px
    scale: float  # px per m
    unit: float  # px in the picture of what is 1 px at PIXELS_PER_METRE on a preset
    left: float  # m, at pixel 0
    drop_y: float  # m
    start: float  # px, where balls start
    bin_top: float  # px
    bin_height: float  # px

    def px(self, x: Number) -> Number:
        """Metres to pixels, across."""
        return (x - self.left) * self.scale

    def py(self, y: Number) -> Number:
        """Metres to pixels, down."""
        return (y - self.drop_y) * self.scale + self.start

    def cut(self, x: int, y: int, width: int, height: int) -> "View":
        """The view of a part of the picture, its corner at (x, y); px."""
        left, start, bin_top = self.left + x / self.scale, self.start - y, self.bin_top - y
        return replace(self, left=left, start=start, bin_top=bin_top, width=width, height=height)


def lay_out(board: Board, width: int) -> View:
    """The view of `board` on a picture `width` pixels wide; InvalidValueError out of range."""
    if not LEAST_WIDTH <= width <= MOST_WIDTH:
        raise InvalidValueError(
            f"width {width} is not a whole number of pixels from {LEAST_WIDTH} to {MOST_WIDTH}",
            field="width",
        )
    left, right = _sides(board)
    span, fall = right - left, board.bins.y - board.drop.y
    scale = min(width / span, MAX_ASPECT * width / fall)
    left -= 0.5 * (width / scale - span)
    unit = max(width / (REFERENCE_WIDTH * PIXELS_PER_METRE), LEAST_UNIT)
    slots = 16.0 * unit if board.slots else 0.0
    start = HEADER * unit + max(HEADROOM * unit, board.ball.radius * scale + 14.0 * unit) + slots
    bin_top = start + fall * scale
    bin_height = max(BIN_LEAST * unit, min(BIN_MOST * unit, 0.5 * scale))
    return View(
        width=width,
        height=round(bin_top + bin_height + 6.0 * unit),
        scale=scale,
        unit=unit,
        left=left,
        drop_y=board.drop.y,
        start=start,
        bin_top=bin_top,
        bin_height=bin_height,
    )


def _sides(board: Board) -> tuple[float, float]:
    """Left and right end of what is shown, in metres."""
    zone, radius = board.drop, board.ball.radius
    xs = [board.bins.edges[0], board.bins.edges[-1]]
    xs += [zone.x - zone.jitter - radius, zone.x + zone.jitter + radius]
    xs += [x for wall in board.walls for x in (wall.x1, wall.x2)]
    xs += [peg.x for peg in board.pegs]
    return min(xs) - SIDE_PAD, max(xs) + SIDE_PAD
