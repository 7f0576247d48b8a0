"""Proves the bin as a function of the start, pixel by pixel.

A pixel stands for an interval of starts. One proof with a wide ball as start may hold for a whole
run of pixels, and proves them all. Elsewhere the middle of each pixel is proven.
"""

import itertools
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.certified.certify import Effort, exact_start, prove
from plinko.engine.errors import ParameterError, shorten
from plinko.engine.exact.outcome import LANDED

UNSETTLED = -1
UNDECIDED = -2
OUTSIDE = -3
"""In place of a bin: proven not to land, undecided, or outside the starts that the board allows."""

WIDE_DEPTH = 3
"""Halvings after which, if no run is proven yet, each pixel is proven separately."""

DEEPEST = 40
"""Zooms by ten: 1e-40 of the widest map, far below the spacing of float64."""

MAP_EFFORT = Effort(first_bits=160, most_bits=1280, most_comparisons=20_000)


@dataclass(frozen=True, slots=True)
class Strip:
    """A row of pixels: their bins from left to right, and the number of proofs.

    `whole` is the number of pixels proven for all their starts, not only for their middle.
    """

    x: Fraction
    width: Fraction
    bins: npt.NDArray[np.int16]
    proofs: int
    whole: int


def widest(board: Board) -> Fraction:
    """The width of the map at level 0, m: all starts that the board allows."""
    return 2 * Fraction(board.drop.span)


def starts_of(board: Board) -> tuple[Fraction, Fraction]:
    """The lowest and the highest x at which a ball may start, m."""
    zone = board.drop
    xs = (zone.x - zone.span, zone.x + zone.span, *zone.slots)
    return Fraction(min(xs)), Fraction(max(xs))


def strip_at(
    board: Board,
    x: float | int | str | Fraction,
    level: int,
    pixels: int,
) -> Strip:
    """A strip of `pixels`, zoomed 10^level times about x, in m; ParameterError for a bad value."""
    if not 0 <= level <= DEEPEST:
        raise ParameterError(f"level {level} is not from 0 to {DEEPEST}", field="level")
    middle = exact_start(x)
    low, high = starts_of(board)
    if not low <= middle <= high:
        raise ParameterError(
            f"x {shorten(x if isinstance(x, str) else float(middle))} is not a start: the starts "
            f"of {board.name!r} are from {float(low):g} to {float(high):g} m",
            field="x",
        )
    width = widest(board) / 10**level
    if width == 0:
        raise ParameterError(
            f"{board.name} has only one start; a map needs a board with a range of starts",
            field="board",
        )
    work = _Work(board, middle - width / 2, width / pixels)
    bins = work.bins(pixels)
    return Strip(middle, width, bins, work.proofs, work.whole)


class _Work:
    """Runs and counts the proofs of one strip."""

    def __init__(self, board: Board, left: Fraction, pixel: Fraction) -> None:
        self.board, self.left, self.pixel = board, left, pixel
        self.proofs = self.whole = 0
        self.low, self.high = starts_of(board)

    def bins(self, pixels: int) -> npt.NDArray[np.int16]:
        """The bin of each pixel.

        One proof is tried for all pixels, then one for each half of an unproven run, down to single
        pixels. Wide proofs are given up if none has succeeded by WIDE_DEPTH.
        """
        bins = np.full(pixels, UNDECIDED, np.int16)
        left = [(0, pixels)]
        for depth in itertools.count():
            if not left or (depth == WIDE_DEPTH and not self.whole):
                break
            halves = []
            for start, end in left:
                found = self._stretch(start, end - start)
                if found != UNDECIDED:
                    bins[start:end] = found
                    self.whole += end - start
                elif end - start > 1:
                    middle = (start + end) // 2
                    halves += [(start, middle), (middle, end)]
                else:
                    bins[start] = self._pixel(start)
            left = halves
        for start, end in left:
            for i in range(start, end):
                bins[i] = self._pixel(i)
        return bins

    def _stretch(self, first: int, count: int) -> int:
        """The bin of all starts of `count` pixels, if one proof holds for them, else UNDECIDED."""
        middle = self.left + self.pixel * (first + Fraction(count, 2))
        half = self.pixel * count / 2
        if not (self.low <= middle - half and middle + half <= self.high):
            return UNDECIDED
        # The width of the start limits this proof: more bits would not help, so only one attempt.
        bits = max(MAP_EFFORT.first_bits, 2 * half.denominator.bit_length())
        return self._bin(middle, half, Effort(bits, bits, MAP_EFFORT.most_comparisons))

    def _pixel(self, number: int) -> int:
        middle = self.left + self.pixel * (number + Fraction(1, 2))
        if not self.low <= middle <= self.high:
            return OUTSIDE
        return self._bin(middle, Fraction(0), MAP_EFFORT)

    def _bin(self, x: Fraction, radius: Fraction, effort: Effort) -> int:
        self.proofs += 1
        path = prove(self.board, x, radius, effort).path
        if path is None:
            return UNDECIDED
        return path.bin if path.outcome == LANDED else UNSETTLED
