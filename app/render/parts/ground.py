"""Paint the backdrops of places, such as craters and dunes, as static/js/paint/ground.js does.

`static/theme.json` has all sizes and positions, for both. Most patterns repeat or reach across the
picture; their coverage is therefore a formula of a pixel's centre (x, y).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.raster.canvas import Array, Canvas, Gradient, covered
from plinko.app.render.theme import Theme, parse
from plinko.engine.json_text import Json, JsonObject

TURN: Final = 2.0 * math.pi

Coverage = npt.NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Place:
    """Arguments of all backdrops: x of the balls' start in px, the picture's unit, the theme."""

    x: float
    unit: float
    theme: Theme

    @property
    def step(self) -> float:
        """The i-th element of a pattern varies by the fractional part of i times this."""
        step: float = self.theme.grounds["step"]
        return step

    def plate(self, ground: str) -> Json:
        """Measures of the pattern on the plate."""
        return self.theme.grounds[ground]["plate"]

    def around(self, ground: str) -> Json:
        """Measures of the pattern around the plate."""
        return self.theme.grounds[ground]["around"]


Paint = Callable[[Canvas, Place], None]


def paint_plate(canvas: Canvas, place: Place) -> None:
    """Paint the pattern on the plate; the theme's `ground` must not be `rays`."""
    _PLATES[place.theme.ground](canvas, place)


def paint_surroundings(canvas: Canvas, place: Place) -> None:
    """Paint the pattern around the plate; the theme's `ground` must not be `rays`."""
    _SURROUNDINGS[place.theme.ground](canvas, place)


def _scatter(count: int) -> Iterator[tuple[float, float, int]]:
    """Points spread evenly over the unit square: Roberts' R2 sequence."""
    for i in range(count):
        yield (0.5 + i * 0.7548776662) % 1.0, (0.5 + i * 0.569840291) % 1.0, i


def _columns(canvas: Canvas) -> Array:
    return np.arange(canvas.width, dtype=np.float32)[None, :] + np.float32(0.5)


def _rows(canvas: Canvas, first: int = 0, end: int | None = None) -> Array:
    last = canvas.height if end is None else end
    return np.arange(first, last, dtype=np.float32)[:, None] + np.float32(0.5)


def _stroke(distance: Coverage, width: float) -> Array:
    """Coverage by a line, for pixels at a `distance` in px from its middle."""
    return covered(0.5 * width - distance)


def _sky(canvas: Canvas, place: Place) -> None:
    """Paint stars, and planets lit from the upper left."""
    sky = place.around(place.theme.ground)
    width, height = canvas.width, canvas.height
    for x, y, i in _scatter(sky["stars"]):
        size = (0.0006 + 0.0013 * ((i * 0.3819) % 1.0)) * width + 0.3 * place.unit
        alpha = 0.25 + 0.6 * ((i * place.step) % 1.0)
        canvas.disc(x * width, y * height, size, (255, 255, 255), alpha)
    for body in sky["planets"]:
        last = len(body["colours"]) - 1
        stops = [(i / last, *parse(colour), 1.0) for i, colour in enumerate(body["colours"])]
        light = Gradient({"x": -0.4, "y": -0.4, "radius": 0.1}, stops)
        radius = max(2.0, body["size"] * width)
        canvas.ball(body["x"] * width, body["y"] * height, radius, light)


def _craters(canvas: Canvas, place: Place) -> None:
    plate, theme = place.plate("craters"), place.theme
    rim = plate["rim"]
    for x, y, i in _scatter(plate["count"]):
        radius = canvas.width * (plate["least"] + plate["more"] * ((i * place.step) % 1.0) ** 2)
        cx, cy, shift = x * canvas.width, y * canvas.height, rim["shift"] * radius
        canvas.disc(cx + shift, cy + shift, rim["size"] * radius, theme["ray"], rim["alpha"])
        canvas.disc(cx, cy, radius, theme["boardDeep"], plate["alpha"])


def _between(canvas: Canvas, upper: Coverage, lower: Coverage | None, name: str, alpha: float,
             theme: Theme) -> None:  # fmt: skip
    """Fill the area between two curves, given as y in px per column; None: down to the end."""
    top = max(int(upper.min()) - 1, 0)
    end = canvas.height if lower is None else min(int(lower.max()) + 2, canvas.height)
    if top >= end:
        return
    ys = _rows(canvas, top, end)
    depth = ys - upper
    canvas.blend(0, top, covered(depth if lower is None else np.minimum(depth, lower - ys)),
                 theme[name], alpha)  # fmt: skip


def _dunes(canvas: Canvas, place: Place) -> None:
    plate = place.plate("dunes")
    count, ripple = plate["count"], plate["ripple"]
    for i in range(count):
        top = canvas.height * (plate["top"] + plate["reach"] * i / count)
        phase = (_columns(canvas) / canvas.width + (i * place.step) % 1.0) * TURN
        wave = np.sin(phase) + ripple["part"] * np.sin(ripple["times"] * phase + i)
        name = "boardDeep" if i % 2 else "ray"
        upper = top + plate["swell"] * canvas.height * wave
        _between(canvas, upper, None, name, plate["alphas"][i % 2], place.theme)


def _bands(canvas: Canvas, place: Place) -> None:
    plate = place.plate("bands")
    part = _columns(canvas) / canvas.width
    top = plate["top"]
    for i, thick in enumerate(plate["thick"]):
        upper, lower = (
            canvas.height * (y + e["swell"] * np.sin(e["times"] * part + e["shift"] * i))
            for y, e in zip((top, top + thick), plate["edges"], strict=True)
        )
        name = "boardDeep" if i % 2 else "ray"
        _between(canvas, upper, lower, name, plate["alphas"][i % 2], place.theme)
        top += thick + plate["between"]
    _spot(canvas, plate["spot"])


def _spot(canvas: Canvas, spot: JsonObject) -> None:
    across, down = spot["across"] * canvas.width, spot["down"] * canvas.height
    cx, cy = spot["x"] * canvas.width, spot["y"] * canvas.height
    left, top = max(int(cx - across) - 1, 0), max(int(cy - down) - 1, 0)
    dx = _columns(canvas)[:, left : int(cx + across) + 2] - cx
    dy = _rows(canvas, top, min(int(cy + down) + 2, canvas.height)) - cy
    for size, alpha in spot["rings"]:
        coverage = covered(-_ellipse_distance(dx, dy, size * across, size * down))
        canvas.blend(left, top, coverage, parse(spot["colour"]), alpha)


def _ellipse_distance(dx: Coverage, dy: Coverage, a: float, b: float) -> Coverage:
    """Distance from an ellipse of half axes a and b, to first order near it; negative inside."""
    rho = np.hypot(dx / a, dy / b)
    slope = np.hypot(dx / (a * a), dy / (b * b))
    distance: Coverage = (rho - 1.0) * rho / np.maximum(slope, 1e-9)
    return distance


def _panes(canvas: Canvas, place: Place) -> None:
    plate = place.plate("panes")
    _beams(canvas, place, "ray", plate["beams"])
    side, slant = plate["side"] * canvas.width, plate["slant"]
    line = max(place.unit, plate["line"] * canvas.width)
    xs, ys = _columns(canvas), np.float32(slant) * _rows(canvas)
    away = np.minimum(_off(xs - ys, side), _off(xs + ys, side)) / math.hypot(1.0, slant)
    leads = _stroke(away, line)
    canvas.blend(0, 0, leads, place.theme["rail"], plate["alpha"])


def _off(u: Array, side: float) -> Array:
    """Distance of u from the nearest multiple of `side`."""
    off: Array = abs((u + np.float32(0.5 * side)) % np.float32(side) - np.float32(0.5 * side))
    return off


def _beams(canvas: Canvas, place: Place, name: str, alpha: float) -> None:
    """Paint slanted beams of light, which must not touch each other."""
    beams = place.theme.grounds["panes"]["beams"]
    steep = math.hypot(1.0, beams["slant"])
    u = (_columns(canvas) + np.float32(beams["slant"]) * _rows(canvas)) / np.float32(steep)
    coverage = np.zeros(u.shape, np.float32)
    for i, (at, wide) in enumerate(beams["at"]):
        left, right = (edge * canvas.width / steep for edge in (at, at + wide))
        coverage += (beams["dim"] if i % 2 else 1.0) * covered(np.minimum(u - left, right - u))
    canvas.blend(0, 0, coverage, place.theme[name], alpha)


def _glass_around(canvas: Canvas, place: Place) -> None:
    _beams(canvas, place, "shoulderRay", place.around("panes")["beams"])


def _plates(canvas: Canvas, place: Place) -> None:
    plate, theme, unit = place.plate("plates"), place.theme, place.unit
    count = math.ceil((canvas.height / unit - 1.0) / plate["every"])
    marks = 1.0 + plate["every"] * np.arange(count)
    strength = plate["alphas"][0] + plate["alphas"][1] * ((marks * place.step) % 1.0)
    # A line covers half a unit above and below its mark; `share` is a row's part of all lines.
    row = np.arange(canvas.height)[:, None]
    begin, end = unit * (marks - 0.5), unit * (marks + 0.5)
    share = np.clip(np.minimum(row + 1.0, end) - np.maximum(row, begin), 0.0, None) @ strength
    brushed = np.broadcast_to(share.astype(np.float32)[:, None], (canvas.height, canvas.width))
    canvas.blend(0, 0, brushed, theme["ray"])
    seam, rivets = plate["seam"], plate["rivets"]
    for at in plate["seams"]:
        y = round(at * canvas.height)
        corners = (0.0, float(y), float(canvas.width), y + seam["high"] * unit)
        canvas.box(corners, 0.0, theme["railShade"], seam["alpha"])
        middle, size = y - rivets["above"] * canvas.width, rivets["size"] * canvas.width
        for i in range(rivets["count"]):
            x = (i + 0.5) / rivets["count"] * canvas.width
            canvas.disc(x, middle, size, theme["pegDark"], rivets["alpha"])


def _hazard(canvas: Canvas, place: Place) -> None:
    """Paint stripes at 45 degrees, as wide as the gaps between them."""
    stripe = place.around("plates")["stripe"] * canvas.width
    v = (_columns(canvas) + _rows(canvas)) % np.float32(2.0 * stripe)
    depth = 0.5 * stripe - abs(v - 0.5 * stripe)
    depth = np.maximum(depth, v - 2.0 * stripe)  # distance to the next stripe
    canvas.blend(0, 0, covered(depth / math.sqrt(2.0)), place.theme["shoulderRay"])


def _court(canvas: Canvas, place: Place) -> None:
    plate, width, height = place.plate("court"), canvas.width, canvas.height
    line = max(2.0 * place.unit, plate["line"] * width)
    dx, ys = _columns(canvas) - place.x, _rows(canvas)
    dy = ys - plate["y"] * height
    near = np.minimum(abs(np.hypot(dx, dy) - plate["circle"] * width), abs(dy))
    near = np.minimum(near, abs(dx))
    canvas.blend(0, 0, _stroke(near, line), place.theme["ray"], plate["alpha"])
    top = max(int(height - plate["goal"] * width - line), 0)
    goal = abs(np.hypot(dx, ys[top:] - height) - plate["goal"] * width)
    canvas.blend(0, top, _stroke(goal, line), place.theme["ray"], plate["alpha"])


def _bounces(canvas: Canvas, place: Place) -> None:
    """Paint the path of a ball bouncing away to each side: dashed arcs of decreasing height."""
    around, width, height = place.around("court"), canvas.width, canvas.height
    line = max(2.0 * place.unit, around["line"] * width)
    for side in (-1, 1):
        x, reach, high = 0.5 * width, around["reach"] * width, around["high"] * height
        for _ in range(around["bounces"]):
            middle = (x + side * reach, around["y"] * height)
            _arc(canvas, middle, (reach, high), line, around["dash"] * width, place.theme)
            x += 2 * side * reach
            reach *= around["nearer"]
            high *= around["lower"]


def _arc(canvas: Canvas, middle: tuple[float, float], axes: tuple[float, float], line: float,
         dash: float, theme: Theme) -> None:  # fmt: skip
    """Paint the upper half of an ellipse, dashed from its left end."""
    (cx, cy), (a, b) = middle, axes
    left, right = max(int(cx - a - line), 0), min(int(cx + a + line) + 1, canvas.width)
    top, end = max(int(cy - b - line), 0), min(math.ceil(cy), canvas.height)
    if left >= right or top >= end:
        return
    dx = _columns(canvas)[:, left:right] - cx
    dy = _rows(canvas, top, end) - cy
    turns = np.linspace(0.0, math.pi, 257)
    steps = np.hypot(np.diff(a * np.cos(turns)), np.diff(b * np.sin(turns)))
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    along = np.interp(math.pi - np.arctan2(-dy / b, dx / a), turns, lengths) % (2.0 * dash)
    dashed = covered(np.minimum(along, dash - along))
    ring = _stroke(abs(_ellipse_distance(dx, dy, a, b)), line)
    canvas.blend(left, top, ring * dashed, theme["shoulderRay"])


_PLATES: Final[dict[str, Paint]] = {
    "craters": _craters,
    "dunes": _dunes,
    "bands": _bands,
    "panes": _panes,
    "plates": _plates,
    "court": _court,
}

_SURROUNDINGS: Final[dict[str, Paint]] = {
    "craters": _sky,
    "dunes": _sky,
    "bands": _sky,
    "panes": _glass_around,
    "plates": _hazard,
    "court": _bounces,
}
