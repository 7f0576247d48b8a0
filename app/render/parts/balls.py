"""Paint balls in the page's appearance: shadow, body with a turning band, gloss, and a trail."""

import functools
import math
from dataclasses import dataclass

import numpy as np

from plinko.app.render.raster import pixels as compiled
from plinko.app.render.raster.canvas import Gradient
from plinko.app.render.raster.palette import Pixels
from plinko.app.render.theme import Theme, named
from plinko.engine.physics.array_types import Floats

LEAST_RADIUS = 2.0  # px; a smaller ball is drawn in this size, so that viewers can find it

TRAIL_POINTS = 8
TRAIL_STEP = 1 / 55
"""s between two points of a trail."""


@dataclass(frozen=True)
class Style:
    """The appearance of balls of one size in one theme; lengths in px."""

    radius: float
    paint: compiled.BallPaint
    trail_width: float
    trail_alpha: float


@functools.lru_cache(maxsize=16)
def style_of(radius: float, theme_name: str, *, asleep: bool = False) -> Style:
    """The appearance of a ball with a radius in px: red, or grey if it sleeps."""
    theme = named(theme_name)
    shape, trail = theme.shapes["ball"], theme.shapes["trail"]
    radius = max(radius, LEAST_RADIUS)
    names = ("other", "otherDark") if asleep else ("ball", "ballBand")
    body, band, shadow = (np.array(theme[name], np.float64) for name in (*names, "shadow"))
    paint = compiled.BallPaint(
        body=body,
        band=band,
        half_band=shape["band"],
        shadow=shadow,
        shadow_across=shape["shadow"]["across"],
        shadow_down=shape["shadow"]["down"],
        shadow_alpha=shape["shadow"]["alpha"],
        gloss=_gloss(radius, theme, asleep),
    )
    return Style(radius, paint, 2.0 * trail["width"] * radius, trail["alpha"])


def _gloss(radius: float, theme: Theme, asleep: bool) -> Floats:
    """The gloss, which does not turn with the ball: colour and opacity, shape (n, n, 4)."""
    shape = theme.shapes["ball"]
    lights = {"light": theme["ballLight"], "dark": theme["ballDark"]}
    if asleep:
        lights = {"light": (255, 255, 255), "dark": theme["otherDark"]}
    stops = [(stop["at"], *lights[stop["colour"]], stop["alpha"]) for stop in shape["gloss"]]
    size = min(2 * max(round(2.0 * radius), 8) + 1, 257)  # two samples per pixel
    axis = np.linspace(-1.0, 1.0, size)
    return Gradient(shape["highlight"], stops).over(axis[None, :], axis[:, None])


def paint_trail(pixels: Pixels, points: Floats, style: Style, lowest: int) -> None:
    """Paint the ribbon behind a ball through `points` (n, 2), px, newest first."""
    rows = _rows(points[:, 1], style.trail_width, len(pixels))
    compiled.paint_trail(
        pixels[rows], points - (0.0, rows.start), style.trail_width, lowest - rows.start,
        style.paint.body, style.trail_alpha,
    )  # fmt: skip


def paint_balls(
    pixels: Pixels,
    xs: Floats,
    ys: Floats,
    thetas: Floats,
    style: Style,
    lowest: int,
    radii: Floats | None = None,
) -> None:
    """Paint balls at (xs, ys) in px, turned by `thetas` in rad, each shape (n,).

    `radii` in px if they differ. Rows from `lowest` on do not change: there a ball is hidden behind
    the bins' faces.
    """
    if radii is None:
        radii = np.full(len(xs), style.radius)
    if not len(xs):
        return
    rows = _rows(ys, 2.0 * float(radii.max()), len(pixels))
    balls = np.column_stack([xs, ys - rows.start, np.cos(thetas), np.sin(thetas), radii])
    compiled.paint_balls(pixels[rows], balls, lowest - rows.start, style.paint)


def _rows(ys: Floats, reach: float, height: int) -> slice:
    """The rows within `reach` px of `ys`.

    A kernel gets only these rows, because its argument is copied. Subtracting a whole row number
    from a y is exact, so the painted pixels are the same.
    """
    first = min(max(float(ys.min()) - reach - 2.0, 0.0), float(height))
    last = min(max(float(ys.max()) + reach + 2.0, first), float(height))
    return slice(int(first), math.ceil(last))
