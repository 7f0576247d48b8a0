"""Draw how many balls landed in each bin, compared with the board's recorded odds."""

from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.errors import InvalidValueError
from plinko.app.render.parts.caption import paint_strip, paint_words
from plinko.app.render.parts.prizes import tight
from plinko.app.render.parts.view import HEADER, View, lay_out
from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas, text_width
from plinko.app.render.still import DEFAULT_WIDTH
from plinko.app.render.theme import Scheme, Theme, at_place, named
from plinko.engine import Board
from plinko.engine.drops.calibrate import sampling_floor, total_variation
from plinko.engine.payouts.record import odds_of_record
from plinko.engine.physics.array_types import Floats

ASPECT: Final = 0.56  # height over width
FACE: Final = 34.0  # px, height of the bins' faces below the columns
SPREAD: Final = 2.0  # half height of the band of expectation, in standard deviations
LEAST_TEXT: Final = 7.0  # px; a share whose letters would be smaller is not written


def histogram_picture(
    board: Board | str,
    counts: npt.ArrayLike,
    fmt: encode.Still = "png",
    width: int = DEFAULT_WIDTH,
    theme: Scheme = "light",
    unsettled_count: int = 0,
) -> bytes:
    """Draw `counts`, the balls in each bin, shape (bins,), as columns; `png`, `jpg` or `webp`.

    board: a Board, or a preset's name. `unsettled_count` balls did not land. If the board's odds
    are on record, each column has a mark at the expected share with a band of two standard
    deviations. Raises InvalidValueError if an argument is invalid.
    """
    board = Board.named(board)
    found = np.asarray(counts, np.int64)
    if found.shape != (board.bins.count,) or (found < 0).any():
        raise InvalidValueError(
            f"counts {found.tolist()!r:.60} must be {board.bins.count} numbers, each at least 0",
            field="counts",
        )
    view = lay_out(board, width)
    return encode.still(_Chart(board, found, unsettled_count, view, theme).painted(), fmt)


def expected_of(board: Board) -> Floats | None:
    """Recorded odds of the bins from the board's own start, shape (bins,), or None."""
    odds = odds_of_record(board)
    return np.array(odds[0].chances) if odds else None


class _Chart:
    """A histogram during painting."""

    def __init__(
        self,
        board: Board,
        counts: npt.NDArray[np.int64],
        unsettled_count: int,
        view: View,
        theme: str,
    ) -> None:
        self.board = board
        self.view = view
        self.theme: Theme = named(at_place(theme, board.name))
        self.counts = counts
        self.unsettled_count = unsettled_count
        self.expected = expected_of(board)
        self.height = round(ASPECT * view.width)
        self.floor = self.height - (FACE + 10.0) * view.unit
        self.canvas = Canvas.blank(view.width, self.height, self.theme["tray"])
        self.edges = np.linspace(16.0 * view.unit, view.width - 16.0 * view.unit, len(self) + 1)
        total = max(int(self.counts.sum()), 1)
        shares = [*(self.counts / total), *([] if self.expected is None else self.expected)]
        top = (HEADER + 30.0) * view.unit
        self.scale = (self.floor - top) / max(*shares, 1e-9)  # px per share of 1
        self.total = total

    def __len__(self) -> int:
        return len(self.counts)

    def painted(self) -> npt.NDArray[np.uint8]:
        """Paint everything; returns pixels (h, w, 3)."""
        canvas, view, theme = self.canvas, self.view, self.theme
        room = paint_strip(canvas, view, theme)
        paint_words(canvas, view, theme, self._title(), self._facts(), room)
        for number in range(len(self)):
            self._paint_column(number)
            self._paint_face(number)
            if self.expected is not None:
                self._paint_expected(number, float(self.expected[number]))
        if self.expected is not None:
            self._paint_legend()
        return canvas.bytes()

    def _column(self, number: int) -> tuple[float, float]:
        left, right = self.edges[number : number + 2].tolist()
        gap = max(1.0, min(3.0 * self.view.unit, 0.06 * (right - left)))
        return left + gap, right - gap

    def _paint_column(self, number: int) -> None:
        left, right = self._column(number)
        share = self.counts[number] / self.total
        top = self.floor - self.scale * share
        if self.counts[number]:
            fill = self.theme.payout(self.board.bins.multipliers[number]).fill
            self.canvas.box((left, min(top, self.floor - 1.0), right, self.floor), 0.0, fill)
        words = f"{100.0 * share:.2g}%" if share < 0.0995 else f"{100.0 * share:.1f}%"
        size = min(13.0 * self.view.unit, (right - left) / text_width("10.0%", 100.0) * 100.0)
        if size >= LEAST_TEXT and self.counts[number]:
            self._paint_share(number, words, size, top)

    def _paint_share(self, number: int, words: str, size: float, top: float) -> None:
        """Write the share above its column, or inside if the expected mark is higher."""
        middle = 0.5 * sum(self._column(number))
        mark = self.floor - self.scale * self._mark(number)
        apart = 0.7 * size
        if mark >= top:
            self.canvas.text(middle, top - apart, words, size, self.theme["trayInk"])
        elif self.floor - top > 2.5 * size:
            ink = self.theme.payout(self.board.bins.multipliers[number]).ink
            chance = self._chance(number)
            foot = self.floor - self.scale * (chance - self._spread(chance))
            self.canvas.text(middle, max(top, foot) + apart, words, size, ink)
        else:
            self.canvas.text(middle, mark - apart, words, size, self.theme["trayInk"])

    def _chance(self, number: int) -> float:
        return 0.0 if self.expected is None else float(self.expected[number])

    def _mark(self, number: int) -> float:
        """The share at the upper end of the band of expectation."""
        chance = self._chance(number)
        return chance + self._spread(chance)

    def _spread(self, chance: float) -> float:
        return float(SPREAD * np.sqrt(chance * (1.0 - chance) / self.total))

    def _paint_expected(self, number: int, chance: float) -> None:
        left, right = self._column(number)
        spread, thick = self._spread(chance), 1.2 * self.view.unit
        level = self.floor - self.scale * chance
        band = (left, level - self.scale * spread, right, level + self.scale * spread)
        self.canvas.box((*band[:3], min(band[3], self.floor)), 0.0, self.theme["trayMark"], 0.3)
        self.canvas.box((left, level - thick, right, level + thick), thick, self.theme["trayMark"])

    def _paint_face(self, number: int) -> None:
        left, right = self._column(number)
        score = self.board.bins.multipliers[number]
        style, unit = self.theme.payout(score), self.view.unit
        top, bottom = self.floor + 4.0 * unit, self.floor + (4.0 + FACE) * unit
        self.canvas.box(
            (left, top, right, bottom), min(6.0 * unit, 0.2 * (right - left)), style.fill
        )
        words = tight(score)
        size = min(15.0 * unit, 0.84 * (right - left) / text_width(words, 100.0) * 100.0)
        upright = size < 8.0
        if upright:
            room = 0.8 * (bottom - top) / text_width(words, 100.0) * 100.0
            size = min(15.0 * unit, 0.9 * (right - left), room)
        place = (0.5 * (left + right), 0.5 * (top + bottom))
        self.canvas.text(*place, words, size, style.ink, upright=upright)

    def _paint_legend(self) -> None:
        """Explain the marks, in the upper left corner."""
        unit, theme = self.view.unit, self.theme
        left, level = 20.0 * unit, (HEADER + 16.0) * unit
        ends = (left, level - 5.0 * unit, left + 24.0 * unit, level + 5.0 * unit)
        self.canvas.box(ends, 0.0, theme["trayMark"], 0.3)
        line = (left, level - 1.2 * unit, left + 24.0 * unit, level + 1.2 * unit)
        self.canvas.box(line, 1.2 * unit, theme["trayMark"])
        words = f"expected: the board's odds, \u00b1{SPREAD:g} standard deviations"
        size = max(11.0 * unit, 8.0)
        self.canvas.text(left + 32.0 * unit, level, words, size, theme["trayInk"], "lm")

    def _title(self) -> str:
        drops = self.counts.sum() + self.unsettled_count
        return f"{self.board.name}   where {drops:,} drops landed"

    def _facts(self) -> list[str]:
        # An unsettled drop gives its stake back.
        paid = float(self.counts @ np.array(self.board.bins.multipliers)) + self.unsettled_count
        drops = max(int(self.counts.sum()) + self.unsettled_count, 1)
        facts = [f"return {100.0 * paid / drops:.2f} % of the stakes"]
        if self.expected is not None and self.counts.any():
            apart = total_variation(self.counts, self.expected)
            chance = sampling_floor(self.expected, self.total)
            facts.append(f"{apart:.4f} from the odds (chance alone: {chance:.4f})")
        return [*facts, f"unsettled {self.unsettled_count:,}"] if self.unsettled_count else facts
