"""Paint a drop's path, copies of the ball along it, and its contacts."""

import math
from typing import Final

import numpy as np

from plinko.app.render.parts.balls import LEAST_RADIUS
from plinko.app.render.parts.view import View
from plinko.app.render.raster import pixels as compiled
from plinko.app.render.raster.palette import Pixels
from plinko.app.render.theme import Colour, Theme
from plinko.engine import Board, Drop
from plinko.engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL
from plinko.engine.physics.array_types import Floats

STRIDE: Final = 2.0  # px between samples of the path where the ball is fastest
MAX_SAMPLES: Final = 20_000  # of one path; a ball that rolls for minutes gets longer chords
FAINTEST: Final = 0.45  # opacity of the path at its start; it grows to 1 at the end
WIDER: Final = 0.2  # px added to the path's width, because soft edges look thin
GHOSTS: Final = 24  # copies of the ball along its path, at equal time intervals
GHOST: Final = 0.55  # opacity of a copy


def sample_times(d: Drop, view: View, until: float) -> Floats:
    """Times in s up to `until` at which to sample the path: closely spaced, and all impacts."""
    impacts = d.impacts[d.impacts["t"] <= until]
    # A bound of the speed: the highest after an impact, plus the gain in the longest flight.
    times = np.concatenate([[0.0], impacts["t"], [until]])
    fall = d.board.gravity * np.diff(times).max()
    fastest = float(np.hypot(impacts["vx"], impacts["vy"]).max(initial=0.0)) + fall
    count = math.ceil(until * fastest * view.scale / STRIDE) + 2
    even = np.linspace(0.0, until, min(count, MAX_SAMPLES))
    return np.unique(np.concatenate([even, impacts["t"]]))


def points_at(d: Drop, view: View, times: Floats) -> Floats:
    """The centre of the ball in px at `times`, shape (n, 2)."""
    states = d.states(times)
    points = np.column_stack([view.px(states["x"]), view.py(states["y"])])
    # A ball that left the board may be anywhere, and pixel indices are integers.
    size = np.array([view.width, view.height], dtype=np.float64)
    nearby: Floats = np.clip(points, -size, 2.0 * size)
    return nearby


def paint_path(pixels: Pixels, d: Drop, view: View, theme: Theme, until: float) -> None:
    """Paint the path up to `until` s, with dark edges for contrast, and more opaque at its end."""
    times = sample_times(d, view, until)
    points = points_at(d, view, times)
    fresh = FAINTEST + (1.0 - FAINTEST) * times[1:] / max(until, 1e-9)
    levels = np.stack([np.ones(len(fresh)), fresh])
    coats = [
        (4.6 * view.unit + WIDER, 0.5, *theme["shadow"]),
        (2.4 * view.unit + WIDER, 1.0, *theme["flash"]),
    ]
    compiled.paint_line(pixels, points, levels, np.array(coats, np.float64))


class Strokes:
    """Lines and discs in px, painted together by one kernel call, each over the previous ones."""

    def __init__(self) -> None:
        self._strokes: list[tuple[float, ...]] = []
        self._colours: list[Colour] = []

    def line(
        self,
        ends: tuple[float, float, float, float],
        width: float,
        colour: Colour,
        alpha: float = 1.0,
    ) -> None:
        """Add a straight line x1, y1, x2, y2 with round ends."""
        self._strokes.append((*ends, 0.5 * width, alpha))
        self._colours.append(colour)

    def disc(self, x: float, y: float, radius: float, colour: Colour, alpha: float = 1.0) -> None:
        self.line((x, y, x, y), 2.0 * radius, colour, alpha)

    def paint(self, pixels: Pixels) -> None:
        if self._strokes:
            strokes, colours = (np.array(a, np.float64) for a in (self._strokes, self._colours))
            compiled.paint_strokes(pixels, strokes, colours)


def paint_ghosts(pixels: Pixels, d: Drop, view: View, theme: Theme, until: float) -> None:
    """Paint the ball at equal time intervals, like a stroboscope: far apart where it is fast."""
    count = max(round(GHOSTS * until / d.duration), 1) if d.duration > 0.0 else 1
    radius = max(d.board.ball.radius * view.scale, LEAST_RADIUS)
    strokes = Strokes()
    for state in d.states(np.linspace(0.0, until, count + 1)[1:-1]):
        x, y = _at(view, float(state["x"]), float(state["y"]))
        theta = float(state["theta"])
        dx, dy = 0.5 * radius * math.cos(theta), 0.5 * radius * math.sin(theta)
        # Without gloss, so that nobody mistakes it for the ball.
        strokes.disc(x, y, radius, theme["ball"], GHOST)
        ends = (x - dx, y - dy, x + dx, y + dy)
        strokes.line(ends, 0.3 * radius, theme["ballBand"], 0.7 * GHOST)
    strokes.paint(pixels)


def paint_contacts(pixels: Pixels, d: Drop, view: View, theme: Theme, until: float) -> None:
    """Paint a spark at each contact up to `until` s; its size grows with the speed afterwards."""
    strokes = Strokes()
    for impact in d.impacts[d.impacts["t"] <= until]:
        if impact["kind"] == KIND_LANDING:
            continue
        x, y = _at(view, *_touching_point(d.board, impact))
        speed = math.hypot(float(impact["vx"]), float(impact["vy"]))
        size = (1.6 + 0.5 * min(speed, 4.0)) * view.unit
        strokes.disc(x, y, size + 1.2 * view.unit, theme["shadow"], 0.5)
        strokes.disc(x, y, size, theme["flash"])
    strokes.paint(pixels)


def _at(view: View, x: float, y: float) -> tuple[float, float]:
    """A position in px, clipped because a ball may have left the board: pixels are integers."""
    far = 4.0 * max(view.width, view.height)
    return min(max(view.px(x), -far), far), min(max(view.py(y), -far), far)


def _touching_point(board: Board, impact: np.void) -> tuple[float, float]:
    """The contact point of an impact in m: one radius from the ball's centre to the surface."""
    x, y = float(impact["x"]), float(impact["y"])
    nearest = _surface_point(board, impact, x, y)
    dx, dy = nearest[0] - x, nearest[1] - y
    distance = math.hypot(dx, dy)
    reach = board.ball.radius / distance if distance > 0.0 else 0.0
    return x + dx * reach, y + dy * reach


def _surface_point(board: Board, impact: np.void, x: float, y: float) -> tuple[float, float]:
    """The point in whose direction the surface lies: a peg's centre, or a wall's nearest point."""
    kind, index = int(impact["kind"]), int(impact["index"])
    # Contact events name a peg by its index and wall w as -1 - w; a wall's impact as w.
    wall_index = index if kind == KIND_WALL else -1 - index
    if kind == KIND_PEG or (kind != KIND_WALL and index >= 0):
        peg = board.pegs[index]
        return peg.x, peg.y
    wall = board.walls[wall_index]
    dx, dy = wall.x2 - wall.x1, wall.y2 - wall.y1
    along = ((x - wall.x1) * dx + (y - wall.y1) * dy) / (dx * dx + dy * dy)
    along = min(max(along, 0.0), 1.0)
    return wall.x1 + along * dx, wall.y1 + along * dy
