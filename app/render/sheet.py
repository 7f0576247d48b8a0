"""Draw a contact sheet: the paths of many drops side by side, each with its seed and result."""

import math
from collections.abc import Callable, Sequence
from typing import Final

from plinko.app.errors import InvalidValueError
from plinko.app.render.parts.prizes import result_of
from plinko.app.render.parts.view import MOST_WIDTH, View, fit
from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas, text_width
from plinko.app.render.raster.palette import Pixels
from plinko.app.render.still import drop_pixels
from plinko.app.render.theme import Scheme, Theme, at_place, named
from plinko.engine import Board, Drop, drop

MOST_DROPS: Final = 256
MOST_PIXELS: Final = 1 << 25
DEFAULT_WIDTH: Final = 1140  # px
LEAST_TILE: Final = 96  # px wide; in a smaller tile the path is illegible
GAP: Final = 8  # px around each tile
LABEL: Final = 20  # px, height of the strip with seed and result above a tile


def contact_sheet(
    board: Board | str,
    seeds: Sequence[int],
    fmt: encode.Still = "png",
    width: int = DEFAULT_WIDTH,
    theme: Scheme = "light",
    columns: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> bytes:
    """Draw the drops of `seeds`, at most MOST_DROPS, in `fmt`: `png`, `jpg` or `webp`.

    board: a Board, or a preset's name. Without `columns` there are as many columns as rows, if they
    fit. `progress` is called with the number of drops done. Raises InvalidValueError if the tiles
    do not fit, and the engine's errors.
    """
    board = Board.named(board)
    if not 1 <= len(seeds) <= MOST_DROPS:
        raise InvalidValueError(
            f"a sheet has 1 to {MOST_DROPS} drops, not {len(seeds)}", field="drops"
        )
    chosen = _default_columns(len(seeds), width) if columns is None else columns
    if not 1 <= chosen <= len(seeds):
        raise InvalidValueError(
            f"columns {chosen} is not from 1 to {len(seeds)}, the number of drops",
            field="columns",
        )
    across = (width - GAP) // chosen - GAP
    if width > MOST_WIDTH or across < LEAST_TILE:
        least = chosen * (LEAST_TILE + GAP) + GAP
        raise InvalidValueError(
            f"width {width} is not from {least}, which {chosen} columns need, to {MOST_WIDTH} px",
            field="width",
        )
    view = fit(board, across, header=0.0)
    placed = at_place(theme, board.name)
    sheet = _blank(len(seeds), view, placed, width, chosen)
    for number, seed in enumerate(seeds):
        _put(sheet, drop(board, seed), number, view, placed, chosen)
        if progress:
            progress(number + 1)
    return encode.still(sheet, fmt)


def _default_columns(count: int, width: int) -> int:
    return max(min(math.ceil(math.sqrt(count)), (width - GAP) // (LEAST_TILE + GAP)), 1)


def _blank(count: int, view: View, theme_name: str, width: int, columns: int) -> Pixels:
    rows = math.ceil(count / columns)
    height = rows * (view.height + LABEL + GAP) + GAP
    if width * height > MOST_PIXELS:
        raise InvalidValueError(
            f"{count} drops in {columns} columns make a sheet of {width} x {height} px, more than "
            f"{MOST_PIXELS:,} pixels in all: use more columns or a smaller width",
            field="columns",
        )
    return Canvas.blank(width, height, named(theme_name)["case"]).bytes()


def _put(sheet: Pixels, d: Drop, number: int, view: View, theme_name: str, columns: int) -> None:
    pitch_x, pitch_y = view.width + GAP, view.height + LABEL + GAP
    left = (sheet.shape[1] - columns * pitch_x + GAP) // 2
    x, y = left + number % columns * pitch_x, GAP + number // columns * pitch_y
    sheet[y : y + LABEL, x : x + view.width] = _label(d, view.width, named(theme_name))
    tile = drop_pixels(d, view, theme_name)
    sheet[y + LABEL : y + LABEL + view.height, x : x + view.width] = tile


def _label(d: Drop, width: int, theme: Theme) -> Pixels:
    """The strip above a tile: the seed, and the payout on a plate in its colour."""
    strip = Canvas.blank(width, LABEL, theme["case"])
    paid, fill, ink = result_of(d, theme)
    size = 12.0
    wide = text_width(paid, size) + 10.0
    strip.box((width - wide, 1.0, float(width), LABEL - 3.0), 4.0, fill)
    strip.text(width - 0.5 * wide, 0.5 * LABEL - 1.0, paid, size, ink)
    room, seed = width - wide - 4.0, f"seed {d.seed}"
    if text_width(seed, size) > room:
        size = room / text_width(seed, 100.0) * 100.0
    strip.text(1.0, 0.5 * LABEL - 1.0, seed, size, theme["ink"], "lm")
    return strip.bytes()
