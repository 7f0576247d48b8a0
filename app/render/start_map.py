"""Draw the bin as a function of the start: strips one below the other, each zoomed by ten."""

import colorsys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.theme import Colour, at_place, named
from plinko.engine import Board

if TYPE_CHECKING:
    from plinko.engine.certified.start_map import Strip

LABELS: Final = 96  # px, width of the labels at the left
STRIP: Final = 16  # px, height of a strip
GAP: Final = 2  # px between two strips
HEAD: Final = 34  # px, height of the title
SPREAD: Final = 0.82  # of the circle of hues, so that the outermost bins differ
GREY: Final[Colour] = (128, 128, 128)


def map_picture(
    board: Board, strips: Sequence["Strip"], fmt: str = "png", theme: str = "light"
) -> bytes:
    """Draw the strips in `fmt`: `png`, `jpg` or `webp`. A start of a strip is one pixel wide."""
    style = named(at_place(theme, board.name))
    pixels = max(len(strip.bins) for strip in strips)
    height = HEAD + len(strips) * (STRIP + GAP)
    canvas = Canvas.blank(LABELS + pixels + GAP, height, style["tray"])
    proofs = sum(strip.proofs for strip in strips)
    title = f"{board.name}: the bin of each start, by {proofs:,} proofs"
    canvas.text(8.0, HEAD / 2.0, title, 13.0, style["trayInk"], "lm")
    for row, strip in enumerate(strips):
        top = HEAD + row * (STRIP + GAP)
        words = f"{float(strip.width):.0e} m"
        canvas.text(LABELS - 10.0, top + STRIP / 2.0, words, 11.0, style["trayInk"], "rm")
        colours = np.array([colour_of(int(b), board.bins.count, style["tray"]) for b in strip.bins])
        canvas.pixels[top : top + STRIP, LABELS : LABELS + len(strip.bins)] = colours[None]
    return encode.still(canvas.bytes(), fmt)


def colour_of(number: int, bins: int, outside: Colour) -> Colour:
    """The colour of a bin: hues from left to right, every other one darker.

    White: the ball stays on the board. Grey: undecided. `outside`: not a start of the board.
    """
    from plinko.engine.certified.start_map import OUTSIDE, UNDECIDED, UNSETTLED  # noqa: PLC0415

    plain = {UNSETTLED: (255, 255, 255), UNDECIDED: GREY, OUTSIDE: outside}
    if number in plain:
        return plain[number]
    hue = SPREAD * number / max(bins - 1, 1)
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.72, 0.95 if number % 2 else 0.72)
    return round(255.0 * red), round(255.0 * green), round(255.0 * blue)
