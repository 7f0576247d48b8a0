"""Checks whether a drop's path keeps the physical laws, independently of the solver.

The check uses the path that the public interface returns and the board, and none of the solvers'
own geometry.
"""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from plinko.engine import Board, Drop, drop
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.parameters import Stepped

Floats = npt.NDArray[np.float64]

FAULTS = ("NaN", "tunnelling", "escape", "hang", "energy growth")
"""The faults that are counted; none may ever happen."""

BETWEEN = 12
"""States that are checked between two events."""

DEPTH = 1e-9
"""Overlap that rounding may cause, relative to the sizes involved (radii, coordinates)."""

STEPPED_DEPTH = 1e-4
"""The same for the stepped solver, relative to the ball's radius. In a notch it corrects the ball
out of one surface and thereby into the other, by what gravity adds in a step; observed: 7e-6."""

GAIN = 1e-9
"""Energy gain that rounding may cause, relative to the largest energy of the drop."""

HANG = 20.0
"""Wall seconds; a drop that takes longer counts as hung, although it ended."""

KEPT = 5
"""Findings kept of each fault: one is enough to debug, and thousands would show the same bug."""


@dataclass
class Findings:
    """Counts over many drops, and the first faulty drops, so that they can be replayed."""

    drops: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    unsettled: Counter[str] = field(default_factory=Counter)
    kept: list[dict[str, Any]] = field(default_factory=list)

    def add(self, other: "Findings") -> None:
        """Add the findings of another part of the work."""
        self.drops += other.drops
        self.faults += other.faults
        self.unsettled += other.unsettled
        for item in other.kept:
            self._keep(item)

    def note(self, what: str, board: Board, x: float, solver: dict[str, Any], size: float) -> None:
        """Count a fault, and keep the drop."""
        self.faults[what] += 1
        place = {"board": board.to_dict(), "x": x, "x_hex": x.hex()}
        self._keep({"fault": what, "size": size, **place, "solver": solver})

    def _keep(self, item: dict[str, Any]) -> None:
        if sum(kept["fault"] == item["fault"] for kept in self.kept) < KEPT:
            self.kept.append(item)


def examine(board: Board, xs: Sequence[float], solver: dict[str, Any]) -> Findings:
    """Drop a ball from each of `xs` (m) and check its path; `solver`: keyword arguments of drop."""
    found = Findings()
    pegs = np.array([(p.x, p.y, p.radius) for p in board.pegs]).reshape(-1, 3)
    walls = np.array([(w.x1, w.y1, w.x2, w.y2) for w in board.walls]).reshape(-1, 4)
    for x in xs:
        start = time.perf_counter()
        played = drop(board, x=float(x), **solver)
        if time.perf_counter() - start > HANG:
            found.note("hang", board, float(x), solver, HANG)
        found.drops += 1
        if played.unsettled:
            found.unsettled[played.unsettled.split(":")[0]] += 1
        for what, size in _faults(played, pegs, walls):
            found.note(what, board, float(x), solver, size)
    return found


def _faults(played: Drop, pegs: Floats, walls: Floats) -> list[tuple[str, float]]:
    board = played.board
    faults = []
    states = played.states(_times(played))
    values = np.array([states[name] for name in ("x", "y", "vx", "vy", "omega", "theta")])
    if not (np.isfinite(values).all() and np.isfinite([played.duration, played.x_end]).all()):
        return [("NaN", 0.0)]
    left, right = board.bins.edges[0], board.bins.edges[-1]
    if played.unsettled is None and not left <= played.x_end <= right:
        faults.append(("escape", played.x_end))
    if played.unsettled and played.unsettled.startswith("escaped"):
        faults.append(("escape", played.x_end))
    depth = deepest(values[0], values[1], pegs, walls, board.ball.radius)
    size = max(board.ball.radius, float(np.abs(values[:2]).max()))
    allowed = DEPTH * size
    if isinstance(played.solver, Stepped):
        allowed = max(allowed, STEPPED_DEPTH * board.ball.radius)
    if depth > allowed:
        faults.append(("tunnelling", depth))
    gain = _energy_gain(played, values)
    if gain > 0.0:
        faults.append(("energy growth", gain))
    return faults


def _times(played: Drop) -> Floats:
    """The start, the events, the end, and BETWEEN - 1 instants between neighbours of these."""
    stops = np.unique(np.concatenate([[0.0], played.impacts["t"], [played.duration]]))
    parts = np.linspace(0.0, 1.0, BETWEEN, endpoint=False)
    inner = stops[:-1, None] + np.diff(stops)[:, None] * parts
    return np.concatenate([inner.ravel(), stops[-1:]])


def _energy_gain(played: Drop, values: Floats) -> float:
    """Growth of energy per mass (J/kg) beyond the allowed growth; 0 if it is within.

    With the exact solver, energy may never grow. With the stepped one, an impact within a step of
    h leaves the ball with up to g h |v| too much. Twice that is allowed for each impact, and as
    much once more for the current step.
    """
    board = played.board
    _, y, vx, vy, omega, _ = values
    kinetic = 0.5 * (vx * vx + vy * vy) + 0.25 * (board.ball.radius * omega) ** 2
    energy = kinetic - board.gravity * y
    largest = float(kinetic.max() + board.gravity * np.ptp(y))
    rounding = GAIN * largest + 1e-15 * board.gravity * float(np.abs(y).max())
    if isinstance(played.solver, Stepped):
        hits = played.impacts[np.isin(played.impacts["kind"], (KIND_PEG, KIND_WALL))]
        speeds = np.hypot(hits["vx"], hits["vy"]).sum() + np.sqrt(2.0 * kinetic.max())
        allowed = 2.0 * board.gravity * played.solver.h * float(speeds) + rounding
        allowed += (board.gravity * played.solver.h) ** 2 * (1 + len(hits))
        gain = float((energy - energy[0]).max()) - allowed
    else:
        gain = float((energy - np.minimum.accumulate(energy)).max()) - rounding
    return max(0.0, gain)


@njit(cache=False, error_model="numpy")
def deepest(xs: Floats, ys: Floats, pegs: Floats, walls: Floats, radius: float) -> float:
    """Largest overlap (m) of a ball at any (xs[i], ys[i]) with a peg or a wall.

    A passage through a wall between two states counts as an overlap of one radius.
    """
    worst = 0.0
    for i in range(xs.shape[0]):
        for k in range(pegs.shape[0]):
            dx = xs[i] - pegs[k, 0]
            dy = ys[i] - pegs[k, 1]
            reach = radius + pegs[k, 2]
            if abs(dx) < reach and abs(dy) < reach:
                worst = max(worst, reach - np.sqrt(dx * dx + dy * dy))
        for k in range(walls.shape[0]):
            wx = walls[k, 2] - walls[k, 0]
            wy = walls[k, 3] - walls[k, 1]
            px = xs[i] - walls[k, 0]
            py = ys[i] - walls[k, 1]
            ww = wx * wx + wy * wy
            along = min(max((px * wx + py * wy) / ww, 0.0), 1.0)
            dx = px - along * wx
            dy = py - along * wy
            worst = max(worst, radius - np.sqrt(dx * dx + dy * dy))
            if i > 0:
                before = (xs[i - 1] - walls[k, 0]) * wy - (ys[i - 1] - walls[k, 1]) * wx
                after = px * wy - py * wx
                if before * after < 0.0:
                    part = before / (before - after)
                    cx = xs[i - 1] + part * (xs[i] - xs[i - 1]) - walls[k, 0]
                    cy = ys[i - 1] + part * (ys[i] - ys[i - 1]) - walls[k, 1]
                    if 0.0 <= cx * wx + cy * wy <= ww:
                        worst = max(worst, radius)
    return worst
