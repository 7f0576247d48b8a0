"""How labels are written in the bins of a picture: across or upright, in lines, cut if need be.

The font has the letters of English alone. Letters with marks are written without them; a label with
other letters is told by its colour, and its bin has the multiplier in it.
"""

import functools
import itertools
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

from app.render.parts.view import View
from app.render.raster.canvas import can_write, text_width
from app.render.theme import Colour, Payout, Theme
from engine import Board, Drop, Label

LEAST, MOST = 9.0, 22.0
"""px at full size, of letters."""

LINES = 3
LINE_HEIGHT = 1.15
"""Of the letters' size."""


@dataclass(frozen=True, slots=True)
class Lettering:
    """The lines that are written in a bin, in letters of `size` px; upright: read from below."""

    lines: tuple[str, ...]
    size: float
    upright: bool


@functools.lru_cache(maxsize=4)
def lettering(board: Board, view: View) -> tuple[Lettering, ...]:
    """Of each bin of a board that has labels: the way around in which the smallest is largest."""
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
    """The words in a room of so many px along and across their lines, as large as they fit."""
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
    """All ways to break a text between its words into at most `LINES` lines."""
    each = words.split()
    for count in range(LINES):
        for breaks in itertools.combinations(range(1, len(each)), count):
            ends = itertools.pairwise((0, *breaks, len(each)))
            yield tuple(" ".join(each[start:end]) for start, end in ends)


def writable(text: str) -> str | None:
    """The text as the font can write it, without the marks on its letters; None if it cannot."""
    parts = unicodedata.normalize("NFKD", text.replace("ß", "ss"))
    plain = "".join(part for part in parts if not unicodedata.category(part).startswith("M"))
    return plain if can_write(plain) else None


def _cut(word: str, most: float) -> str:
    """The word, cut at its end if it is wider than `most` letters' heights."""
    if text_width(word, 100.0) <= 100.0 * most:
        return word
    while len(word) > 1 and text_width(f"{word}…", 100.0) > 100.0 * most:
        word = word[:-1].rstrip()
    return f"{word}…"


def look_of(board: Board, number: int, theme: Theme) -> tuple[Colour, Colour]:
    """A bin's fill and the ink on it: its label's colour, or else that of what it pays."""
    bins = board.bins
    label = bins.labels[number] if bins.labels else None
    return _own(label, theme.payout(bins.multipliers[number]))


def result_of(d: Drop, theme: Theme) -> tuple[str, Colour, Colour]:
    """What a drop came to in words, the fill of the plate that says so, and the ink on it."""
    if d.bin is None:
        look = theme.payout(d.score)
        return "unsettled", look.fill, look.ink
    words = (d.label and writable(d.label)) or f"{d.score:g}x"
    return (words, *look_of(d.board, d.bin, theme))


def _own(label: Label | None, payout: Payout) -> tuple[Colour, Colour]:
    if label is None or label.colour is None:
        return payout.fill, payout.ink
    fill = tuple(int(label.colour[at : at + 2], 16) for at in (1, 3, 5))
    return (fill[0], fill[1], fill[2]), _ink_on(fill)


def _ink_on(fill: tuple[int, ...]) -> Colour:
    """Black or white, whichever can be read better: WCAG's relative luminance decides."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (each / 255.0 for each in fill)
    )
    return (0, 0, 0) if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 else (255, 255, 255)


def tight(value: float) -> str:
    """A multiplier as short as it can be read: 110, 1.5, .5."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return text.removeprefix("0") if text.startswith("0.") else text
