"""Balls as the page draws them: shadow, body with a band that turns, gloss, and a trail behind."""

import functools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from app.render.raster import pixels as compiled
from app.render.raster.canvas import Gradient
from app.render.theme import Theme, named

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]

LEAST_RADIUS = 2.0  # px: a smaller ball is drawn as large as this, or nobody finds it

TRAIL_POINTS = 8
TRAIL_STEP = 1 / 55
"""s between the points of a trail."""


@dataclass(frozen=True)
class Look:
    """A ball of one size in one theme's colours, ready to be painted often; lengths in px."""

    radius: float
    paint: compiled.BallPaint
    trail_width: float
    trail_alpha: float


@functools.lru_cache(maxsize=16)
def look_of(radius: float, theme_name: str, *, asleep: bool = False) -> Look:
    """The red ball with a radius in px; grey when it sleeps."""
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
    return Look(radius, paint, 2.0 * trail["width"] * radius, trail["alpha"])


def _gloss(radius: float, theme: Theme, asleep: bool) -> Floats:
    """The light on a ball, which does not turn with it: colour and opacity, shape (n, n, 4)."""
    shape = theme.shapes["ball"]
    lights = {"light": theme["ballLight"], "dark": theme["ballDark"]}
    if asleep:
        lights = {"light": (255, 255, 255), "dark": theme["otherDark"]}
    stops = [(stop["at"], *lights[stop["colour"]], stop["alpha"]) for stop in shape["gloss"]]
    size = min(2 * max(round(2.0 * radius), 8) + 1, 257)  # two samples a pixel
    axis = np.linspace(-1.0, 1.0, size)
    return Gradient(shape["highlight"], stops).over(axis[None, :], axis[:, None])


def paint_trail(pixels: Pixels, points: Floats, look: Look, lowest: int) -> None:
    """The ribbon behind a ball through `points` (n, 2), px, newest first."""
    rows = _rows(points[:, 1], look.trail_width, len(pixels))
    compiled.paint_trail(
        pixels[rows], points - (0.0, rows.start), look.trail_width, lowest - rows.start,
        look.paint.body, look.trail_alpha,
    )  # fmt: skip


def paint_balls(
    pixels: Pixels,
    xs: Floats,
    ys: Floats,
    thetas: Floats,
    look: Look,
    lowest: int,
    radii: Floats | None = None,
) -> None:
    """Balls at (xs, ys), px, turned by `thetas`, rad, each shape (n,); `radii` if they differ, px.

    Rows from `lowest` on stay as they are: a ball sinks behind the bins' faces.
    """
    if radii is None:
        radii = np.full(len(xs), look.radius)
    if not len(xs):
        return
    rows = _rows(ys, 2.0 * float(radii.max()), len(pixels))
    balls = np.column_stack([xs, ys - rows.start, np.cos(thetas), np.sin(thetas), radii])
    compiled.paint_balls(pixels[rows], balls, lowest - rows.start, look.paint)


def _rows(ys: Floats, reach: float, height: int) -> slice:
    """Rows that may change by what lies around `ys`: kernels are given no more of a picture, since
    it is copied for them. To subtract the first of them from a y is exact."""
    first = min(max(float(ys.min()) - reach - 2.0, 0.0), float(height))
    last = min(max(float(ys.max()) + reach + 2.0, first), float(height))
    return slice(int(first), math.ceil(last))
