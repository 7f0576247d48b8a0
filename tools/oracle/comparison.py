"""A drop of the exact solver against the oracle's: the same path, impacts and bin.

Paths are compared by places at the same times, so two solvers that name the pieces of one wall
differently, or count a bounce of 1e-12 m/s, agree. Impacts are compared if they are felt.

How far an error grows is measured by runs of the oracle that begin and bounce a little differently.
A path that ends within rounding times this growth is `equal`. Solvers also decide that a bounce is
over, and at slightly different speeds; a wall may lie 1e-15 m beside another, less than rounding.
Such a decision changes speeds by 1e-7 m/s, and the path is then `close`. What lies behind a growth
of CHAOS is not compared: if nothing else differs, the drop is `chaotic`.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.exact.outcome import LANDED
from plinko.engine.parameters import Exact
from plinko.engine.physics import body
from tools.oracle.drop import NUDGE, OracleDrop, oracle_drop

Floats = npt.NDArray[np.float64]

EVEN: Final = 100
"""Times at which places are compared, evenly spaced, in addition to those of impacts."""

ULPS: Final = 64
"""Rounding of a path before it has grown, in units of the last place of the bins' height."""

LOOSE: Final = 1e-6
"""m; error of a path by decisions about the slowest bounces, before it has grown."""

CHAOS: Final = 1e4

FELT: Final = 1e-3
"""m/s; an impact at a slower approach need not be an event of the other solver."""

RUNS: Final = 2
"""Other runs of the oracle, by which growth is measured."""

AROUND: Final = 3
"""Samples to either side whose growth counts too: where two paths cross, their distance is zero."""

EVENTS: Final = 250
"""Events for which the oracle follows a ball; an elastic ball may have any number."""


@dataclass(frozen=True)
class Comparison:
    """verdict: equal, close, chaotic or differs. what: the first difference, or why not told."""

    verdict: str
    what: str = ""


def compare(board: Board, x: float, dps: int = 30) -> Comparison:
    """The solver's drop from x in m against the oracle's, to `dps` digits."""
    oracle = oracle_drop(board, x, dps, max_events=EVENTS)
    path = follow(board, at_start(board, x), Exact())
    return compare_path(board, path, oracle)


def compare_path(board: Board, path: Trajectory, oracle: OracleDrop) -> Comparison:
    """A path of a solver against the oracle's from the same start."""
    times = _times(oracle)
    truth = _places(oracle, times)
    errors = np.hypot(*(path.states_at(times)[:, body.X : body.Y + 1] - truth).T)
    rounding = ULPS * float(np.spacing(abs(board.bins.y)))
    if (errors <= rounding).all():
        what = _difference(board, path, oracle, np.full(len(times), rounding), times)
        if what is None:
            return Comparison("equal")
    growth = np.maximum(1.0, _growth(oracle, times))
    verdicts = (("equal", rounding), ("close", LOOSE))
    for verdict, error in verdicts:
        allowed = error * growth
        wild = np.flatnonzero(growth > CHAOS)
        tame = slice(0, int(wild[0]) if len(wild) else len(times))
        if (errors[tame] > allowed[tame]).any():
            first = int(np.flatnonzero(errors[tame] > allowed[tame])[0])
            what = (
                f"{errors[first]:.3g} m apart at t = {times[first]:.9g}, where errors have grown "
                f"{growth[first]:.3g} times"
            )
            continue
        what = _difference(board, path, oracle, allowed[tame], times[tame])
        if what is None and len(wild):
            return Comparison("chaotic", f"from t = {times[wild[0]]:.9g} on")
        if what is None:
            return Comparison(verdict)
    return Comparison("differs", str(what))


def _times(oracle: OracleDrop) -> Floats:
    """Increasing times in s, among them those of the first impacts that are felt."""
    felt = [float(e.t) for e in oracle.events if e.approach > FELT]
    times = np.concatenate((np.linspace(0.0, float(oracle.duration), EVEN), felt[:EVEN]))
    return np.unique(times[times < float(oracle.duration)])


def _places(oracle: OracleDrop, times: Floats) -> Floats:
    places = [oracle.position_at(t) for t in times.tolist()]
    return np.array([[float(x), float(y)] for x, y in places])


def _growth(oracle: OracleDrop, times: Floats) -> Floats:
    """How many times farther than NUDGE m other runs are at these times, or around them."""
    spread = np.zeros(len(times))
    runs = [oracle.nudged(NUDGE, pattern) for pattern in range(RUNS)]
    for i, t in enumerate(times.tolist()):
        x, y = oracle.position_at(t)
        for run in runs:
            if t > run.duration:
                # Both have ended, all but for rounding, or the run is another path.
                if float(oracle.duration - run.duration) > LOOSE:
                    spread[i] = np.inf
                continue
            other_x, other_y = run.position_at(t)
            distance = ((x - other_x) ** 2 + (y - other_y) ** 2) ** 0.5
            spread[i] = max(spread[i], float(distance / NUDGE))
    near = [spread[max(0, i - AROUND) : i + AROUND + 1].max() for i in range(len(spread))]
    return np.array(near)


def _difference(
    board: Board, path: Trajectory, oracle: OracleDrop, allowed: Floats, times: Floats
) -> str | None:
    """The first impact up to the last of `times` without a partner, or another end."""
    until = float(times[-1])
    mine = path.events[np.isin(path.marks[:, 0], (KIND_PEG, KIND_WALL))]
    theirs = [e for e in oracle.events if e.kind in {KIND_PEG, KIND_WALL}]
    places = np.array([[float(e.t), float(e.x), float(e.y)] for e in theirs]).reshape(-1, 3)
    approach = np.array([float(e.approach) for e in theirs])
    for name, some, others, speeds in (
        ("the oracle", places, mine, approach),
        ("the solver", mine, places, _changes(path, mine)),
    ):
        for (t, x, y), speed in zip(some[:, :3].tolist(), speeds.tolist(), strict=True):
            if speed <= FELT * 10.0 or t >= until:
                continue
            error = max(1e-12, float(allowed[min(np.searchsorted(times, t), len(times) - 1)]))
            near = np.hypot(others[:, 1] - x, others[:, 2] - y) <= 10.0 * error
            near &= np.abs(others[:, 0] - t) <= 10.0 * error / speed
            if not near.any():
                return f"only {name} has an impact of {speed:.3g} m/s at t = {t:.9g}"
    if oracle.reason == "too many events" or until < float(oracle.duration) * (1.0 - 2.0 / EVEN):
        return None
    if (path.outcome == LANDED) != (oracle.reason is None):
        return f"outcome {path.outcome}, and by the oracle {oracle.reason or 'landed'}"
    edge = min(abs(float(oracle.x_end) - edge) for edge in board.bins.edges)
    if path.outcome == LANDED and path.bin != oracle.bin and edge > float(allowed[-1]):
        return f"bin {path.bin}, and by the oracle {oracle.bin}"
    return None


def _changes(path: Trajectory, events: Floats) -> Floats:
    """Changes of the velocity at events, m/s; of simultaneous ones the sum."""
    before = path.states_at(np.nextafter(events[:, 0], -np.inf))
    after = path.states_at(events[:, 0])
    changes: Floats = np.hypot(*(after - before)[:, body.VX : body.VY + 1].T)
    return changes
