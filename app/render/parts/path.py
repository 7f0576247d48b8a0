"""A drop's path, the ball along it as a stroboscope shows it, and its contacts."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from app.render.parts.balls import LEAST_RADIUS
from app.render.parts.view import View
from app.render.raster.canvas import Canvas, polyline_coverage
from app.render.theme import Theme
from engine import Board, Drop
from engine.constants import KIND_LANDING, KIND_PEG, KIND_WALL

Floats = npt.NDArray[np.float64]

STRIDE: Final = 2.0  # px between samples of the path where the ball is fastest
MAX_SAMPLES: Final = 20_000  # of one path: a ball that rolls for minutes gets longer chords
FAINTEST: Final = 0.45  # opacity of the path at its start; it grows to 1 at its end
GHOSTS: Final = 24  # of the ball along its path, at equal time intervals


def sample_times(d: Drop, view: View, until: float) -> Floats:
    """Times in s up to `until` at which the path is sampled: closely spaced, and at impacts."""
    impacts = d.impacts[d.impacts["t"] <= until]
    # Speeds after impacts, and that of the longest possible fall between two of them.
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
    # A ball that left the board may be anywhere: Pillow counts in integers.
    size = np.array([view.width, view.height], dtype=np.float64)
    nearby: Floats = np.clip(points, -size, 2.0 * size)
    return nearby


def paint_path(canvas: Canvas, d: Drop, view: View, theme: Theme, until: float) -> None:
    """The path up to `until` s, dark-edged so that it stands out on pegs, fresher at its end."""
    times = sample_times(d, view, until)
    points = points_at(d, view, times)
    fresh = FAINTEST + (1.0 - FAINTEST) * times[1:] / max(until, 1e-9)
    left, top, size, inside = _framed(points, 6.0 * view.unit, view)
    edge = polyline_coverage(inside, np.ones(len(fresh)), 4.6 * view.unit, size)
    canvas.blend(left, top, edge, theme["shadow"], 0.5)
    line = polyline_coverage(inside, fresh, 2.4 * view.unit, size)
    canvas.blend(left, top, line, theme["flash"])


def _framed(points: Floats, margin: float, view: View) -> tuple[int, int, tuple[int, int], Floats]:
    """Left, top and size in px of the part of the picture with the points; the points in it."""
    low = np.floor(np.maximum(points.min(axis=0) - margin, 0.0)).astype(int)
    high = np.ceil(np.minimum(points.max(axis=0) + margin, view.size)).astype(int)
    width, height = np.maximum(high - low, 1).tolist()
    return int(low[0]), int(low[1]), (width, height), points - low


def paint_ghosts(canvas: Canvas, d: Drop, view: View, theme: Theme, until: float) -> None:
    """The ball at equal time intervals, as a stroboscope shows it: far apart where it is fast."""
    count = max(round(GHOSTS * until / d.duration), 1) if d.duration > 0.0 else 1
    for state in d.states(np.linspace(0.0, until, count + 1)[1:-1]):
        paint_ghost(canvas, d.board, view, theme, state, 0.55)


def paint_ghost(
    canvas: Canvas, board: Board, view: View, theme: Theme, state: np.void, alpha: float
) -> None:
    """Where the ball was: flat, so that it is not taken for the ball."""
    x, y = view.px(float(state["x"])), view.py(float(state["y"]))
    radius = max(board.ball.radius * view.scale, LEAST_RADIUS)
    canvas.disc(x, y, radius, theme["ball"], alpha)
    theta = float(state["theta"])
    dx, dy = 0.5 * radius * math.cos(theta), 0.5 * radius * math.sin(theta)
    ends = (x - dx, y - dy, x + dx, y + dy)
    canvas.line(ends, 0.3 * radius, theme["ballBand"], 0.7 * alpha)


def paint_contacts(canvas: Canvas, d: Drop, view: View, theme: Theme, until: float) -> None:
    """A spark where the ball touched something up to `until` s: larger the harder it left it."""
    for impact in d.impacts[d.impacts["t"] <= until]:
        if impact["kind"] == KIND_LANDING:
            continue
        x, y = _touching_point(d.board, impact)
        speed = math.hypot(float(impact["vx"]), float(impact["vy"]))
        size = (1.6 + 0.5 * min(speed, 4.0)) * view.unit
        canvas.disc(view.px(x), view.py(y), size + 1.2 * view.unit, theme["shadow"], 0.5)
        canvas.disc(view.px(x), view.py(y), size, theme["flash"])


def _touching_point(board: Board, impact: np.void) -> tuple[float, float]:
    """Where the ball met the surface at an impact, m: one radius from its centre towards it."""
    x, y = float(impact["x"]), float(impact["y"])
    nearest = _surface_point(board, impact, x, y)
    dx, dy = nearest[0] - x, nearest[1] - y
    distance = math.hypot(dx, dy)
    reach = board.ball.radius / distance if distance > 0.0 else 0.0
    return x + dx * reach, y + dy * reach


def _surface_point(board: Board, impact: np.void, x: float, y: float) -> tuple[float, float]:
    """The point towards which the touched surface lies: a peg's centre, a wall's nearest point."""
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
