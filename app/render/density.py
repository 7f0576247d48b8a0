"""Draw where the balls of many drops spend their time, as light on the board."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.parts.board import paint_furniture, plate_canvas
from plinko.app.render.parts.caption import paint_strip, paint_words
from plinko.app.render.parts.view import View, lay_out
from plinko.app.render.raster import encode
from plinko.app.render.raster.canvas import Canvas, bands, text_width
from plinko.app.render.still import DEFAULT_WIDTH
from plinko.app.render.theme import Scheme, Theme, at_place, named
from plinko.engine import Board, Occupancy, occupancy
from plinko.engine.batches.density import Grid, occupancy_by
from plinko.engine.batches.workers import Workers
from plinko.engine.drops.batch import Seeds

Floats = npt.NDArray[np.float32]
Steps = npt.NDArray[np.uint8]

RAMP: Final = ("ballDark", "ball", "trayBar", "flash")
"""Names in the theme of the light's colours, from faint to bright."""

STOPS: Final = (0.0, 0.45, 0.8, 1.0)
CONTRAST: Final = 300.0
"""Ratio of the brightest to the faintest visible time; the scale is logarithmic."""

FULL: Final = 0.999  # quantile of the lit cells that gets full brightness
STEPS: Final = 96  # of brightness
OPAQUE: Final = 0.4  # brightness from which the light hides the plate

_LEVELS: Final = (np.arange(STEPS + 1) / STEPS).astype(np.float32)


def density_picture(
    board: Board | str,
    seeds: Seeds,
    fmt: encode.Still = "png",
    width: int = DEFAULT_WIDTH,
    theme: Scheme = "light",
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    workers: Workers | None = None,
) -> bytes:
    """Draw where the balls of `seeds` spend their time, in `fmt`: `png`, `jpg` or `webp`.

    board: a Board, or a preset's name. Each pixel is a cell of the grid; memory does not grow with
    the number of drops. `threads` and `progress` as in `plinko.engine.occupancy`; `workers` compute
    consecutive seeds on other processes or machines. Raises InvalidValueError and the engine's
    errors.
    """
    board = Board.named(board)
    view = lay_out(board, width)
    placed = at_place(theme, board.name)
    top = view.drop_y - view.start / view.scale
    grid = Grid(view.left, top, view.scale, (view.height, view.width))
    if workers is not None and isinstance(seeds, range):
        found = occupancy_by(workers, board, seeds, grid, progress)
    else:
        found = occupancy(board, seeds, threads=threads, progress=progress, **asdict(grid))
    return encode.still(_pixels(found, view, placed), fmt)


def _pixels(found: Occupancy, view: View, theme_name: str) -> npt.NDArray[np.uint8]:
    theme = named(theme_name)
    canvas = plate_canvas(found.board, view, theme_name)
    brightest = _brightest(found)
    light = _light(found, brightest)
    for rows in bands(len(light)):
        part = light[rows]
        canvas.blend(0, rows.start, _opacity(part), _colours(part, theme))
    paint_furniture(canvas, found.board, view, theme)
    room = paint_strip(canvas, view, theme)
    room -= _paint_scale(canvas, view, theme, brightest) + 16.0 * view.unit
    paint_words(canvas, view, theme, _title(found), _facts(found), room)
    return canvas.bytes()


def _brightest(found: Occupancy) -> float:
    """The time in s per drop in a cell that gets full brightness."""
    lit = found.seconds[found.counts > 0]
    return float(np.quantile(lit, FULL)) if len(lit) else 1.0


def _light(found: Occupancy, brightest: float) -> Steps:
    """Brightness of each cell: 0 without any time, STEPS for the brightest, logarithmic between.

    A palette can hold that many steps, and the eye cannot distinguish them.
    """
    light = np.empty(found.seconds.shape, np.uint8)
    for rows in bands(len(light)):
        part = np.minimum(found.seconds[rows] / brightest, 1.0)
        light[rows] = np.rint(np.log1p(CONTRAST * part) / np.log1p(CONTRAST) * STEPS)
    return light


def _opacity(light: Steps) -> Floats:
    opacity: Floats = np.minimum(_LEVELS / OPAQUE, 1.0)[light]
    return opacity


def _colours(light: Steps, theme: Theme) -> Floats:
    stops = np.array([theme[name] for name in RAMP], np.float32)
    channels = [np.interp(_LEVELS, STOPS, stops[:, channel]) for channel in range(3)]
    colours: Floats = np.stack(channels, axis=-1).astype(np.float32)[light]
    return colours


def _title(found: Occupancy) -> str:
    return f"{found.board.name}   density of {found.drops:,} drops"


def _facts(found: Occupancy) -> list[str]:
    facts = [
        f"mean drop {found.duration / max(found.drops, 1):.3f} s",
        f"sampled every {1e3 * found.step:g} ms",
    ]
    return [*facts, f"unsettled {found.unsettled_count:,}"] if found.unsettled_count else facts


def _paint_scale(canvas: Canvas, view: View, theme: Theme, brightest: float) -> float:
    """Paint the scale of brightness at the right with labels; returns its width in px."""
    cell = (100.0 / view.scale) ** 2  # cm^2
    most = f"{1e3 * brightest / cell:.2g} ms per sq cm"
    size = max(11.0 * view.unit, 9.0)
    wide = max(text_width(most, size) + text_width("0", size) + 24.0 * view.unit, 150.0 * view.unit)
    right = view.width - 16.0 * view.unit
    top, bottom = round(0.22 * view.header), round(0.46 * view.header)
    ramp = np.rint(np.linspace(0.0, STEPS, round(wide)))[None].astype(np.uint8)
    cover = _opacity(ramp).repeat(bottom - top, axis=0)
    plate = (right - wide, float(top), right, float(bottom))
    canvas.box(plate, 0.0, theme["board"])
    colours = _colours(ramp, theme).repeat(bottom - top, axis=0)
    canvas.blend(round(right - wide), top, cover, colours)
    low = 0.68 * view.header
    canvas.text(right - wide, low, "0", size, theme["inkSoft"], "lm")
    canvas.text(right, low, most, size, theme["inkSoft"], "rm")
    return wide
