"""Lay out a board on a picture of a given width: the map from metres to pixels, as on the page."""

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from plinko.app.errors import InvalidValueError
from plinko.app.render.theme import Theme
from plinko.engine import Board
from plinko.engine.multibody.static_geometry import StaticGeometry

Number = TypeVar("Number", float, npt.NDArray[np.float64])

LEAST_WIDTH, MOST_WIDTH = 240, 2048
"""px. In a smaller picture labels are illegible; a larger one only takes memory."""

PIXELS_PER_METRE: Final = 100
"""Scale of the reference game's canvas, for which the sizes below are given."""

REFERENCE_WIDTH: Final = 7.6  # m, of that canvas
LEAST_UNIT: Final = 0.6  # lower bound of `View.unit`: thinner lines and letters are illegible

USUAL_WIDTHS: Final = 6.0, 8.0
"""m. On boards of these widths, which the presets have, margins and rails have fixed sizes in m. On
narrower and wider boards they are in proportion, as static/js/paint/geometry.js has them."""

SIDE_PAD: Final = 0.08  # m of margin at each side of a board of a usual width
HEADER: Final = 60.0  # px, height of the caption above the board
HEADROOM: Final = 34.0  # px from the caption to the balls' start, or more for a larger ball
LEAST_HEADROOM: Final = 16.0  # the same without a caption
BIN_LEAST, BIN_MOST = 34.0, 84.0  # px, height of the bins; bins with labels are twice as high
MAX_ASPECT: Final = 2.5
"""Upper bound of the playing field's height over the picture's width. A taller board is drawn
smaller, so that the width bounds a picture's memory for any board."""


@dataclass(frozen=True)
class View:
    """A picture's size and its map from metres to pixels."""

    width: int  # px
    height: int  # px
    scale: float  # px per m
    metre: float  # px per m for the sizes that are given for boards of a usual width
    unit: float  # factor for sizes in px that are given at PIXELS_PER_METRE, such as HEADER
    left: float  # m, the x of pixel 0
    drop_y: float  # m, the y of the balls' start
    start: float  # px, the row of the balls' start
    bin_top: float  # px
    bin_height: float  # px
    header: float  # px, height of the strip with words above the board

    @property
    def size(self) -> tuple[int, int]:
        return self.width, self.height

    @property
    def face(self) -> int:
        """First row of the bins' faces, which hide balls."""
        return max(round(self.bin_top + 2.0), 0)

    def px(self, x: Number) -> Number:
        """The pixel at the horizontal position `x` in m."""
        return (x - self.left) * self.scale

    def py(self, y: Number) -> Number:
        """The pixel at the vertical position `y` in m."""
        return (y - self.drop_y) * self.scale + self.start

    def cut(self, x: int, y: int, width: int, height: int) -> "View":
        """The view of a part of the picture whose upper left corner is (x, y), in px."""
        left, start, bin_top = self.left + x / self.scale, self.start - y, self.bin_top - y
        return replace(self, left=left, start=start, bin_top=bin_top, width=width, height=height)


def lay_out(board: Board, width: int) -> View:
    """Lay out `board` on a picture `width` px wide; the height follows from the board.

    Raises InvalidValueError if the width is out of range.
    """
    check_width(width)
    return fit(board, width, header=HEADER)


def check_width(width: int) -> None:
    """Raise InvalidValueError if a width in px is out of range."""
    if not LEAST_WIDTH <= width <= MOST_WIDTH:
        raise InvalidValueError(
            f"width {width} is not a whole number of pixels from {LEAST_WIDTH} to {MOST_WIDTH}",
            field="width",
        )


def fit(board: Board, width: int, header: float) -> View:
    """Like `lay_out`, for any width, with a strip of `header` px (at full size) above the board."""
    left, right = _ends(board)
    pad = SIDE_PAD * _size(board)
    left, right = left - pad, right + pad
    fall = board.bins.y - board.drop.y
    scale = min(width / (right - left), MAX_ASPECT * width / fall)
    left -= 0.5 * (width / scale - (right - left))
    unit = max(width / (REFERENCE_WIDTH * PIXELS_PER_METRE), LEAST_UNIT)
    slots = 16.0 * unit if board.slots else 0.0
    headroom = HEADROOM if header else LEAST_HEADROOM
    start = max(headroom * unit, board.ball.radius * scale + 14.0 * unit) + slots + header * unit
    bin_top = start + fall * scale
    storeys = 2.0 if board.bins.labels else 1.0
    metre = scale * _size(board)
    bin_height = storeys * max(BIN_LEAST * unit, min(BIN_MOST * unit, 0.5 * metre))
    return View(
        width=width,
        height=round(bin_top + bin_height + 6.0 * unit),
        scale=scale,
        metre=metre,
        unit=unit,
        left=left,
        drop_y=board.drop.y,
        start=start,
        bin_top=bin_top,
        bin_height=bin_height,
        header=header * unit,
    )


def _size(board: Board) -> float:
    """The board's width in units of the nearest usual width."""
    left, right = _ends(board)
    return (right - left) / min(max(right - left, USUAL_WIDTHS[0]), USUAL_WIDTHS[1])


def _ends(board: Board) -> tuple[float, float]:
    """The left and right end of the board's parts in m."""
    zone, radius = board.drop, board.ball.radius
    xs = [board.bins.edges[0], board.bins.edges[-1]]
    xs += [zone.x - zone.span - radius, zone.x + zone.span + radius]
    xs += [x for wall in board.walls for x in (wall.x1, wall.x2)]
    xs += [peg.x for peg in board.pegs]
    return min(xs), max(xs)


def lay_out_place(place: StaticGeometry, width: int, theme: Theme) -> View:
    """Lay out a place on a picture `width` px wide, with a strip for words above it."""
    x0, x1, y0, y1 = place.extent
    unit = max(width / (REFERENCE_WIDTH * PIXELS_PER_METRE), LEAST_UNIT)
    pad, header = theme.shapes["box"]["pad"] * unit, HEADER * unit
    scale = min((width - 2.0 * pad) / (x1 - x0), (MAX_ASPECT * width - 2.0 * pad) / (y1 - y0))
    height = round(header + 2.0 * pad + (y1 - y0) * scale)
    return View(
        width=width,
        height=height,
        scale=scale,
        metre=scale,
        unit=unit,
        left=0.5 * (x0 + x1 - width / scale),
        drop_y=y0,
        start=header + pad,
        bin_top=height - 2.0,  # below the place, because it has no bins that hide balls
        bin_height=2.0,
        header=header,
    )
