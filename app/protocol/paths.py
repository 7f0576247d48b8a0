"""The binary messages of `?stream=paths`: each ball's whole flight, as knots. Pure.

Between two knots the ball moves under the board's drag and one constant acceleration, so a client
draws it in closed form. A free flight is exact: its acceleration is gravity. Where a ball lies on a
surface, or hops too low to be seen, as few pieces as fit within TOLERANCE replace its path.
docs/protocol.md describes every byte; tests/golden/paths.json has examples.
"""

import math
import struct
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.drops.trajectory import Trajectory
from plinko.engine.exact import event_log
from plinko.engine.physics import body

MAGIC: Final = 0x46
VERSION: Final = 1
HEADER: Final = struct.Struct("<BBHIQ")  # magic, version, 0, knots, ball

COLUMNS: Final = ("t", "x", "y", "angle", "ax", "ay", "hit")
"""Of a knot, each a float32: s since the ball's start, m, rad, m/s^2. `hit` is the peg or wall off
which the ball bounces there: a peg's index, or the number of pegs plus a wall's index; else -1."""

TOLERANCE: Final = 1e-4
"""m; the largest error in x and in y: a hundredth of a pixel at 100 px/m."""

TURN_TOLERANCE: Final = 0.05
"""rad; the same for the angle, which changes at a constant rate between two knots."""

MOST_KNOTS: Final = 1024
"""Of a part, 29 kB. A path on a preset has fewer than 100; a longer one comes in several parts."""

LONG: Final = 256
"""Events of a flight that an event loop neither computes nor cuts: more than 0.2 ms and 1 ms. Most
drops on presets have fewer."""

LEAD: Final = 2.0
"""s by which a further part is sent before the ball reaches it."""

_SHARES: Final = np.linspace(0.0, 1.0, 17)  # of a piece, at which it is compared with the path
_MIDDLE: Final = 8
_SHORTEST: Final = 1e-5  # s; a shorter piece along a surface is not halved further
_TOGETHER: Final = 1024  # pieces compared in one step, which bounds the memory: 1 MB

Floats = npt.NDArray[np.float64]


class Part(NamedTuple):
    """A stretch of a ball's path: the ticks at which it is sent and begins, and its bytes."""

    due: int
    begin: int
    data: bytes


Path = list[Part]


def path_of(ball: int, start: int, rate: int, path: Trajectory) -> Path:
    """The path of a ball that starts at tick `start`, at `rate` ticks a second.

    Each part begins with the last knot of the one before.
    """
    knots = knots_of(path)
    parts = []
    for first in range(0, len(knots) - 1, MOST_KNOTS - 1):
        part = knots[first : first + MOST_KNOTS]
        begin = start + math.floor(float(part[0, 0]) * rate)
        due = begin - round(LEAD * rate) if first else start
        data = HEADER.pack(MAGIC, VERSION, 0, len(part), ball) + part.tobytes()
        parts.append(Part(due, begin, data))
    return parts


def due_parts(path: Path, after: int, tick: int) -> bytes:
    """The further parts of a path that are due after tick `after`, up to `tick`."""
    return b"".join(part.data for part in path[1:] if after < part.due <= tick)


def current_parts(path: Path, tick: int) -> bytes:
    """The parts for a client that comes at this tick: the one the ball is in, and those due."""
    past = max(sum(part.begin <= tick for part in path) - 1, 0)
    return b"".join(part.data for part in path[past:] if part.due <= tick)


def knots_of(path: Trajectory) -> npt.NDArray[np.float32]:
    """The knots of an exact drop's path: an array of shape (n, 7), in the order of time.

    They are float32; their places are those at the rounded times.
    """
    pieces = np.vstack((*_pieces(path), np.append(path.end, (0.0, 0.0))))
    pieces = pieces[np.argsort(pieces[:, body.T], kind="stable")]
    knots: npt.NDArray[np.float32] = np.empty((len(pieces), len(COLUMNS)), np.float32)
    knots[:, 0] = pieces[:, body.T]
    late = knots[:, 0].astype(np.float64) - pieces[:, body.T]
    late[-1] = 0.0  # the place of the landing
    columns = ((body.X, body.VX), (body.Y, body.VY), (body.THETA, body.OMEGA))
    for column, (place, speed) in enumerate(columns, 1):
        knots[:, column] = pieces[:, place] + late * pieces[:, speed]
    knots[:, 4:6] = pieces[:, body.SIZE :]
    knots[:, 6] = _hits(path, pieces[:, body.T])
    later = np.append(np.diff(knots[:, 0]) > 0.0, True)
    return np.compress(later, knots, axis=0)


def basis(drag: float, s: Floats) -> tuple[Floats, Floats]:
    """The integral of exp(-drag s), and its integral: the ball's motion by velocity and by push."""
    if drag <= 0.0:
        return s, 0.5 * s * s
    slow = drag * s < 1e-6  # there the difference below has no digits
    phi = -np.expm1(-drag * s) / drag
    return phi, np.where(slow, 0.5 * s * s, (s - phi) / drag)


def _pieces(path: Trajectory) -> Iterator[Floats]:
    """The pieces of a path, in any order: the state at the beginning, and the acceleration."""
    rows, gravity = path.segments, path.board.gravity
    bounds = np.append(rows[:, body.T], path.end[body.T])
    flies = rows[:, event_log.ITEM] == event_log.IN_FLIGHT
    # A shorter flight is within the tolerance of a straight line: it may be part of a piece.
    alone = flies & (np.diff(bounds) > math.sqrt(8.0 * TOLERANCE / max(gravity, 1e-9)))
    yield _flights(rows[alone], gravity)
    edges = np.diff(np.concatenate(([0], ~alone, [0])))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    runs = np.column_stack((first, last, bounds[first], bounds[last]))
    while len(runs := runs[runs[:, 3] > runs[:, 2]]):
        now, later = runs[:_TOGETHER], runs[_TOGETHER:]
        single = flies[now[:, 0].astype(int)] & (now[:, 1] - now[:, 0] == 1.0)
        yield _flights(rows[now[single, 0].astype(int)], gravity)
        pieces, fit = _fitted(path, now[~single])
        yield pieces[fit]
        runs = np.vstack((_halves(now[~single][~fit], bounds), later))


def _flights(rows: Floats, gravity: float) -> Floats:
    pushes = np.broadcast_to((0.0, gravity), (len(rows), 2))
    return np.hstack((rows[:, : body.SIZE], pushes))


def _fitted(path: Trajectory, runs: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """One piece for each run, through its start, middle and end; and whether it fits the path."""
    begin, end = runs[:, 2:3], runs[:, 3:4]
    times = begin + (end - begin) * _SHARES
    states = path.states_at(times.ravel()).reshape(*times.shape, body.SIZE)
    phi, psi = basis(path.board.drag, times - begin)
    share = phi / phi[:, -1:]
    bow = (psi - psi[:, -1:] * share)[..., None]
    places = states[..., [body.X, body.Y]]
    start, stop = places[:, :1], places[:, -1:]
    chord = start + (stop - start) * share[..., None]
    push = (places - chord)[:, _MIDDLE] / bow[:, _MIDDLE]
    off = np.abs(chord + push[:, None] * bow - places).max(axis=(1, 2))
    turns = states[..., body.THETA]
    turned = np.abs(turns[:, :1] + (turns[:, -1:] - turns[:, :1]) * _SHARES - turns).max(axis=1)
    fit = (off <= TOLERANCE) & (turned <= TURN_TOLERANCE) | (runs[:, 3] - runs[:, 2] < _SHORTEST)
    return np.hstack((states[:, 0], push)), fit


def _halves(runs: Floats, bounds: Floats) -> Floats:
    """Each run cut in two: where rows meet nearest to its middle, or within its only row."""
    first, last, begin, end = runs.T
    middle = 0.5 * (begin + end)
    after = np.clip(np.searchsorted(bounds, middle), first + 1, last - 1).astype(int)
    before = np.maximum(after - 1, first + 1).astype(int)
    cut = np.where(np.abs(bounds[after] - middle) < np.abs(bounds[before] - middle), after, before)
    several = last - first > 1
    at = np.where(several, bounds[np.minimum(cut, len(bounds) - 1)], middle)
    left = np.column_stack((first, np.where(several, cut, last), begin, at))
    right = np.column_stack((np.where(several, cut, first), last, at, end))
    return np.vstack((left, right))


def _hits(path: Trajectory, times: Floats) -> npt.NDArray[np.int64]:
    """The surface off which the ball bounces at each of these times, or -1."""
    kinds, indices = path.impacts["kind"], path.impacts["index"]
    bounces = kinds <= KIND_WALL
    at = path.impacts["t"][bounces]
    if not len(at):
        return np.full(len(times), -1)
    surfaces = np.where(kinds == KIND_PEG, indices, indices + len(path.board.pegs))[bounces]
    latest = np.maximum(np.searchsorted(at, times, side="right") - 1, 0)
    return np.where(at[latest] == times, surfaces[latest], -1)
