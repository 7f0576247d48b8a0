"""Balls as the page draws them: shadow, body with a band that turns, gloss, and a trail behind."""

import functools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from app.render import compiled
from app.theme import Colour, named

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]

LEAST_RADIUS = 2.0  # px: a smaller ball is drawn as large as this, or nobody finds it

# The page's own measures (static/js/paint-ball.js, board-view.js), in radii.
HALF_BAND = 0.24
SHADOW_OFFSET = (0.28, 0.5)
SHADOW_ALPHA = 0.35
TRAIL_WIDTH = 1.6
TRAIL_ALPHA = 0.4
TRAIL_POINTS = 14
TRAIL_STEP = 1 / 90
"""s between the points of a trail."""

_HIGHLIGHT = (-0.35, -0.4, 0.1)  # the gloss's inner circle: centre and radius
_GLOSS_STOPS = (0.0, 0.3, 0.65, 1.0)
_GLOSS_ALPHAS = (0xE6 / 255, 0x30 / 255, 0.0, 0xD0 / 255)


@dataclass(frozen=True)
class Look:
    """A ball of one size in one theme's colours, ready to be painted often."""

    radius: float  # px
    body: Floats
    band: Floats
    shadow: Floats
    gloss: Floats


@functools.lru_cache(maxsize=16)
def look_of(radius: float, theme_name: str) -> Look:
    """The red ball with a radius in px."""
    theme = named(theme_name)
    radius = max(radius, LEAST_RADIUS)
    size = min(2 * max(round(2.0 * radius), 8) + 1, 257)  # two samples a pixel
    body, band, shadow = (
        np.array(theme[name], np.float64) for name in ("ball", "ballBand", "shadow")
    )
    gloss = _gloss(size, theme["ballLight"], theme["ballDark"])
    return Look(radius, body, band, shadow, gloss)


def paint_trail(pixels: Pixels, points: Floats, look: Look, lowest: int) -> None:
    """The ribbon behind a ball through `points` (n, 2), px, newest first."""
    width = TRAIL_WIDTH * look.radius
    compiled.paint_trail(pixels, points, width, lowest, look.body, TRAIL_ALPHA)


def paint_balls(
    pixels: Pixels, xs: Floats, ys: Floats, thetas: Floats, look: Look, lowest: int
) -> None:
    """Balls at (xs, ys), px, turned by `thetas`, rad, each shape (n,).

    Rows from `lowest` on stay as they are: a ball sinks behind the bins' faces.
    """
    radius = look.radius
    dx, dy = (offset * radius for offset in SHADOW_OFFSET)
    cosines, sines = np.cos(thetas), np.sin(thetas)
    compiled.paint_balls(
        pixels, xs, ys, cosines, sines, radius, dx, dy, lowest,
        look.shadow, SHADOW_ALPHA, look.body, look.band, HALF_BAND, look.gloss,
    )  # fmt: skip


def _gloss(size: int, light: Colour, dark: Colour) -> Floats:
    """Colour and opacity (size, size, 4) of a radial gradient from the highlight to the rim.

    A point's place s between the circles solves |p - (1 - s) h| = (1 - s) r + s.
    """
    axis = np.linspace(-1.0, 1.0, size)
    x, y = axis[None, :], axis[:, None]
    hx, hy, hr = _HIGHLIGHT
    qx, qy = x - hx, y - hy
    a = hx * hx + hy * hy - (1.0 - hr) ** 2
    b = qx * hx + qy * hy - hr * (1.0 - hr)
    c = qx * qx + qy * qy - hr * hr
    # a < 0: the highlight lies within the rim, so one root is the place.
    place = np.clip((-b - np.sqrt(np.maximum(b * b - a * c, 0.0))) / a, 0.0, 1.0)
    stops = np.array([light, light, dark, dark], np.float64)
    layers = [np.interp(place, _GLOSS_STOPS, stops[:, channel]) for channel in range(3)]
    return np.stack([*layers, np.interp(place, _GLOSS_STOPS, _GLOSS_ALPHAS)], axis=-1)
