"""Where a board lies on a picture of a given width: metres to pixels, as on the page."""

from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from app.errors import InvalidValueError
from app.render.theme import Theme
from engine import Board
from engine.multibody.static_geometry import Place

Number = TypeVar("Number", float, npt.NDArray[np.float64])

LEAST_WIDTH, MOST_WIDTH = 240, 2048
LEAST_HEIGHT = 180
"""px: in a smaller picture labels cannot be read; a larger one costs memory, not looks."""

PIXELS_PER_METRE: Final = 100
"""Scale at which the sizes below are given: that of the reference game's canvas."""

REFERENCE_WIDTH: Final = 7.6  # m, of that canvas
REFERENCE_HEIGHT: Final = 5.7
LEAST_UNIT: Final = 0.6  # of lines and letters in a narrow picture: smaller ones do not print

SIDE_PAD: Final = 0.08  # m, beside the outermost part of the board
HEADER: Final = 60.0  # px, the caption above the board
HEADROOM: Final = 34.0  # px from the caption to where balls start, if no ball is larger
LEAST_HEADROOM: Final = 16.0  # the same without a caption
BIN_LEAST, BIN_MOST = 34.0, 84.0  # px, height of the bins; with labels in them twice as high
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
    header: float  # px, height of the strip with words above the board

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in px."""
        return self.width, self.height

    @property
    def face(self) -> int:
        """First row of the bins' faces, px: balls sink behind them."""
        return max(round(self.bin_top + 2.0), 0)

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


def lay_out(board: Board, width: int, height: int | None = None) -> View:
    """The view of `board` on a picture `width` pixels wide and as high as the board needs.

    With a `height` the board is drawn as large as fits into both. Raises InvalidValueError that
    names a size out of range.
    """
    check_size("width", width)
    if height is not None:
        check_size("height", height)
    return fit(board, width, height, header=HEADER)


def check_size(name: str, value: int) -> None:
    """Raise InvalidValueError for a `width` or `height` in px that no picture can have."""
    least = LEAST_WIDTH if name == "width" else LEAST_HEIGHT
    if not least <= value <= MOST_WIDTH:
        raise InvalidValueError(
            f"{name} {value} is not a whole number of pixels from {least} to {MOST_WIDTH}",
            field=name,
        )


def fit(board: Board, width: int, height: int | None, header: float) -> View:
    """As `lay_out`, for any size, with a strip of `header` px (at full size) above the board."""
    left, right = _sides(board)
    fall = board.bins.y - board.drop.y
    scale = min(width / (right - left), MAX_ASPECT * width / fall)
    if height is None:
        return _at_scale(board, width, None, header, scale)
    low, high = 0.0, scale
    if _at_scale(board, width, None, header, high, height).height > height:
        for _ in range(40):  # halving: the height grows with the scale, in no handy formula
            middle = 0.5 * (low + high)
            tall = _at_scale(board, width, None, header, middle, height).height > height
            low, high = (low, middle) if tall else (middle, high)
        scale = low
    return _at_scale(board, width, height, header, scale, height)


def _at_scale(
    board: Board,
    width: int,
    height: int | None,
    header: float,
    scale: float,
    room: int | None = None,
) -> View:
    """The view at `scale` px a metre; what a given `height` has to spare lies around the board."""
    left, right = _sides(board)
    left -= 0.5 * (width / scale - (right - left))
    size = width if room is None else min(width, room * REFERENCE_WIDTH / REFERENCE_HEIGHT)
    unit = max(size / (REFERENCE_WIDTH * PIXELS_PER_METRE), LEAST_UNIT)
    slots = 16.0 * unit if board.slots else 0.0
    headroom = HEADROOM if header else LEAST_HEADROOM
    start = max(headroom * unit, board.ball.radius * scale + 14.0 * unit) + slots + header * unit
    bin_top = start + (board.bins.y - board.drop.y) * scale
    storeys = 2.0 if board.bins.labels else 1.0
    bin_height = storeys * max(BIN_LEAST * unit, min(BIN_MOST * unit, 0.5 * scale))
    needed = round(bin_top + bin_height + 6.0 * unit)
    spare = 0.0 if height is None else 0.5 * max(height - needed, 0)
    return View(
        width=width,
        height=needed if height is None else height,
        scale=scale,
        unit=unit,
        left=left,
        drop_y=board.drop.y,
        start=start + spare,
        bin_top=bin_top + spare,
        bin_height=bin_height,
        header=header * unit,
    )


def _sides(board: Board) -> tuple[float, float]:
    """Left and right end of what is shown, in metres."""
    zone, radius = board.drop, board.ball.radius
    xs = [board.bins.edges[0], board.bins.edges[-1]]
    xs += [zone.x - zone.span - radius, zone.x + zone.span + radius]
    xs += [x for wall in board.walls for x in (wall.x1, wall.x2)]
    xs += [peg.x for peg in board.pegs]
    return min(xs) - SIDE_PAD, max(xs) + SIDE_PAD


def lay_out_place(place: Place, width: int, theme: Theme) -> View:
    """The view of a place on a picture `width` px wide, with a strip for words above it."""
    x0, x1, y0, y1 = place.extent
    unit = max(width / (REFERENCE_WIDTH * PIXELS_PER_METRE), LEAST_UNIT)
    pad, header = theme.shapes["box"]["pad"] * unit, HEADER * unit
    scale = min((width - 2.0 * pad) / (x1 - x0), (MAX_ASPECT * width - 2.0 * pad) / (y1 - y0))
    height = round(header + 2.0 * pad + (y1 - y0) * scale)
    return View(
        width=width,
        height=height,
        scale=scale,
        unit=unit,
        left=0.5 * (x0 + x1 - width / scale),
        drop_y=y0,
        start=header + pad,
        bin_top=height - 2.0,  # there are no bins whose faces hide a ball
        bin_height=2.0,
        header=header,
    )
