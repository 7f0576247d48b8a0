"""Proves the bin as a function of the start, pixel by pixel.

A pixel stands for an interval of starts. One proof with a wide ball as start may hold for a whole
run of pixels, and proves them all. Elsewhere the middle of each pixel is proven.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

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

    def to_dict(self) -> dict[str, Any]:
        return {
            "x": str(self.x),
            "width": str(self.width),
            "bins": self.bins.tolist(),
            "proofs": self.proofs,
            "whole": self.whole,
        }


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
    first: int = 0,
    count: int | None = None,
    effort: Effort = MAP_EFFORT,
    patience: Callable[[], bool] = lambda: True,
) -> Strip:
    """`count` pixels from `first` on of a strip of `pixels`, zoomed 10^level times about x, in m.

    As soon as `patience` returns False, no further proof begins, and the pixels left are undecided.
    Raises ParameterError that names the bad value.
    """
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
    wanted = pixels - first if count is None else count
    if not (first >= 0 and 0 < wanted <= pixels - first):
        raise ParameterError(
            f"pixels {first} to {first + wanted} are not within a strip of {pixels} pixels",
            field="first",
        )
    work = _Work(board, middle - width / 2, width / pixels, effort, patience)
    bins = np.full(wanted, UNDECIDED, np.int16)
    work.fill(bins, first)
    return Strip(middle, width, bins, work.proofs, work.whole)


class _Work:
    """Runs and counts the proofs of one strip."""

    def __init__(
        self,
        board: Board,
        left: Fraction,
        pixel: Fraction,
        effort: Effort,
        patience: Callable[[], bool],
    ) -> None:
        self.board, self.left, self.pixel = board, left, pixel
        self.effort, self.patience = effort, patience
        self.proofs = self.whole = 0
        self.low, self.high = starts_of(board)

    def fill(self, bins: npt.NDArray[np.int16], first: int) -> None:
        """Write the bins of the pixels from number `first` on.

        One proof is tried for all pixels, then one for each half of an unproven run, down to single
        pixels. Wide proofs are given up if none has succeeded by WIDE_DEPTH.
        """
        left = [(0, len(bins))]
        for depth in itertools.count():
            if not left or (depth == WIDE_DEPTH and not self.whole):
                break
            halves = []
            for start, end in left:
                found = self._stretch(first + start, end - start)
                if found != UNDECIDED:
                    bins[start:end] = found
                    self.whole += end - start
                elif end - start > 1:
                    middle = (start + end) // 2
                    halves += [(start, middle), (middle, end)]
                else:
                    bins[start] = self._pixel(first + start)
            left = halves
        for start, end in left:
            for i in range(start, end):
                bins[i] = self._pixel(first + i)

    def _stretch(self, first: int, count: int) -> int:
        """The bin of all starts of `count` pixels, if one proof holds for them, else UNDECIDED."""
        middle = self.left + self.pixel * (first + Fraction(count, 2))
        half = self.pixel * count / 2
        if not (self.low <= middle - half and middle + half <= self.high):
            return UNDECIDED
        # The width of the start limits this proof: more bits would not help, so only one attempt.
        bits = max(self.effort.first_bits, 2 * half.denominator.bit_length())
        return self._bin(middle, half, Effort(bits, bits, self.effort.most_comparisons))

    def _pixel(self, number: int) -> int:
        middle = self.left + self.pixel * (number + Fraction(1, 2))
        if not self.low <= middle <= self.high:
            return OUTSIDE
        return self._bin(middle, Fraction(0), self.effort)

    def _bin(self, x: Fraction, radius: Fraction, effort: Effort) -> int:
        if not self.patience():
            return UNDECIDED
        self.proofs += 1
        path = prove(self.board, x, radius, effort).path
        if path is None:
            return UNDECIDED
        return path.bin if path.outcome == LANDED else UNSETTLED
