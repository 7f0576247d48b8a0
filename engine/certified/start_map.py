"""The bin as a function of the start, pixel by pixel, each of them proven.

A pixel stands for an interval of starts. Where one proof holds for a whole stretch of them (the
start as a wide ball), it is the proof of all its pixels; elsewhere each pixel's middle is proven.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.certified.certify import Effort, exact_start, prove
from engine.errors import ParameterError
from engine.exact.outcome import LANDED

UNSETTLED = -1
UNDECIDED = -2
OUTSIDE = -3
"""In place of a bin: proven not to land, not decided, not a start that the board allows."""

WIDE_DEPTH = 3
"""How often a stretch is halved before its pixels are proven one by one."""

DEEPEST = 40
"""Zooms by ten: 1e-40 of the widest map, far beyond what float64 tells apart."""

MAP_EFFORT = Effort(first_bits=160, most_bits=1280, most_comparisons=20_000)


@dataclass(frozen=True, slots=True)
class Strip:
    """A row of pixels: their bins from left to right, and how many proofs that took.

    `whole` says how many pixels are proven for every start in them, not only for their middle.
    """

    x: Fraction
    width: Fraction
    bins: npt.NDArray[np.int16]
    proofs: int
    whole: int

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "x": str(self.x),
            "width": str(self.width),
            "bins": self.bins.tolist(),
            "proofs": self.proofs,
            "whole": self.whole,
        }


def widest(board: Board) -> Fraction:
    """The width of the map before any zoom, m: all starts that the board allows."""
    return 2 * Fraction(board.drop.span)


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
    """`count` pixels from `first` on of a strip of `pixels`, 10^level times zoomed about x in m.

    `patience` is asked before each proof; pixels after it has run out are undecided. Raises
    ParameterError that names the bad value.
    """
    if not 0 <= level <= DEEPEST:
        raise ParameterError(f"level {level} is not from 0 to {DEEPEST}", field="level")
    middle = exact_start(x)
    width = widest(board) / 10**level
    if width == 0:
        raise ParameterError(f"{board.name} has one start only: no map", field="board")
    wanted = pixels - first if count is None else count
    if not (first >= 0 and 0 < wanted <= pixels - first):
        raise ParameterError(
            f"pixels {first} to {first + wanted} are not among {pixels}", field="first"
        )
    work = _Work(board, middle - width / 2, width / pixels, effort, patience)
    bins = np.full(wanted, UNDECIDED, np.int16)
    work.fill(bins, first, 0)
    return Strip(middle, width, bins, work.proofs, work.whole)


class _Work:
    """The proofs of one strip."""

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
        zone = board.drop
        self.low = Fraction(min((zone.x - zone.span, *zone.slots)))
        self.high = Fraction(max((zone.x + zone.span, *zone.slots)))

    def fill(self, bins: npt.NDArray[np.int16], first: int, depth: int) -> None:
        """Write the bins of the pixels from number `first` on."""
        count = len(bins)
        middle = self.left + self.pixel * (first + Fraction(count, 2))
        half = self.pixel * count / 2
        if depth < WIDE_DEPTH and self.low <= middle - half and middle + half <= self.high:
            # More bits would not make a wide start narrower: one precision, fit for its width.
            bits = max(self.effort.first_bits, 2 * half.denominator.bit_length())
            found = self._bin(middle, half, Effort(bits, bits, self.effort.most_comparisons))
            if found != UNDECIDED:
                bins[:] = found
                self.whole += count
                return
        if count == 1:
            inside = self.low <= middle <= self.high
            bins[0] = self._bin(middle, Fraction(0), self.effort) if inside else OUTSIDE
            return
        self.fill(bins[: count // 2], first, depth + 1)
        self.fill(bins[count // 2 :], first + count // 2, depth + 1)

    def _bin(self, x: Fraction, radius: Fraction, effort: Effort) -> int:
        if not self.patience():
            return UNDECIDED
        self.proofs += 1
        path = prove(self.board, x, radius, effort).path
        if path is None:
            return UNDECIDED
        return path.bin if path.outcome == LANDED else UNSETTLED
