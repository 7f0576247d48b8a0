"""Fit labels into the bins of a picture: across or upright, in several lines, cut if necessary.

The font has only English letters. Accents are omitted. A label in another script is replaced by its
bin's multiplier, and only its colour is shown.
"""

import functools
import itertools
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

from plinko.app.render.parts.view import View
from plinko.app.render.raster.canvas import can_write, text_width
from plinko.app.render.theme import Colour, Payout, Theme
from plinko.engine import Board, Drop, Label

LEAST, MOST = 9.0, 22.0
"""Sizes of letters in px, at full size of the picture."""

LINES = 3
LINE_HEIGHT = 1.15
"""In units of the letters' size."""


@dataclass(frozen=True, slots=True)
class Lettering:
    """The lines to write in a bin, in letters of `size` px. Upright lines are read upwards."""

    lines: tuple[str, ...]
    size: float
    upright: bool


@functools.lru_cache(maxsize=4)
def lettering(board: Board, view: View) -> tuple[Lettering, ...]:
    """The lettering of each bin of a board with labels.

    All labels have the same direction: the one in which the smallest letters are larger.
    """
    bins = board.bins
    words = [
        (label and writable(label.text)) or tight(pays)
        for label, pays in zip(bins.labels, bins.multipliers, strict=True)
    ]
    widths = [0.78 * view.scale * (b - a) for a, b in itertools.pairwise(bins.edges)]
    height = 0.9 * (view.bin_height - 4.0 * view.unit)
    ways = [
        [
            _fitted(word, (height, width) if upright else (width, height), view.unit, upright)
            for word, width in zip(words, widths, strict=True)
        ]
        for upright in (False, True)
    ]
    return tuple(max(ways, key=lambda way: min(letters.size for letters in way)))


def _fitted(words: str, room: tuple[float, float], unit: float, upright: bool) -> Lettering:
    """Fit the words as large as possible into `room`: px along and across their lines."""
    sized = [(_size(lines, room), lines) for lines in _broken(words)]
    size, lines = max(sized, key=lambda each: each[0])
    least = min(LEAST * unit, room[1] / LINE_HEIGHT)
    if upright and size < least:
        size, lines = least, (_cut(words, room[0] / least),)
    return Lettering(lines, min(size, MOST * unit), upright)


def _size(lines: tuple[str, ...], room: tuple[float, float]) -> float:
    longest = max(text_width(line, 100.0) for line in lines) / 100.0
    return min(room[0] / longest, room[1] / (LINE_HEIGHT * len(lines)))


def _broken(words: str) -> Iterator[tuple[str, ...]]:
    """Yield all ways to break a text between words into at most `LINES` lines."""
    each = words.split()
    for count in range(LINES):
        for breaks in itertools.combinations(range(1, len(each)), count):
            ends = itertools.pairwise((0, *breaks, len(each)))
            yield tuple(" ".join(each[start:end]) for start, end in ends)


def writable(text: str) -> str | None:
    """The text without accents, or None if the font lacks a letter."""
    parts = unicodedata.normalize("NFKD", text.replace("ß", "ss"))
    plain = "".join(part for part in parts if not unicodedata.category(part).startswith("M"))
    return plain if can_write(plain) else None


def _cut(word: str, most: float) -> str:
    """Cut the end of a word that is wider than `most` times the letters' size."""
    if text_width(word, 100.0) <= 100.0 * most:
        return word
    while len(word) > 1 and text_width(f"{word}…", 100.0) > 100.0 * most:
        word = word[:-1].rstrip()
    return f"{word}…"


def style_of(board: Board, number: int, theme: Theme) -> tuple[Colour, Colour]:
    """A bin's fill and ink: from its label's colour if there is one, or from its payout."""
    bins = board.bins
    label = bins.labels[number] if bins.labels else None
    return _own(label, theme.payout(bins.multipliers[number]))


def result_of(d: Drop, theme: Theme) -> tuple[str, Colour, Colour]:
    """A drop's result in words, and the fill and ink of the plate with these words."""
    if d.bin is None:
        style = theme.payout(d.score)
        return "unsettled", style.fill, style.ink
    words = (d.label and writable(d.label)) or f"{d.score:g}x"
    return (words, *style_of(d.board, d.bin, theme))


def _own(label: Label | None, payout: Payout) -> tuple[Colour, Colour]:
    if label is None or label.colour is None:
        return payout.fill, payout.ink
    fill = tuple(int(label.colour[at : at + 2], 16) for at in (1, 3, 5))
    return (fill[0], fill[1], fill[2]), _ink_on(fill)


def _ink_on(fill: tuple[int, ...]) -> Colour:
    """Black or white, whichever has more contrast by WCAG's relative luminance."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (each / 255.0 for each in fill)
    )
    return (0, 0, 0) if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 else (255, 255, 255)


def tight(value: float) -> str:
    """A multiplier in short form: 110, 1.5, .5."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return text.removeprefix("0") if text.startswith("0.") else text
