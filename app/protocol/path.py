"""Cuts a ball's path into segments that a client can draw in closed form: flights and curves. Pure.

A flight is exact: gravity and drag determine it from its initial state. Where a ball lies on a
surface, or hops too low to be seen, a curve replaces the path: a parabola over as long a stretch as
it fits within TOLERANCE. app/protocol/segments.py writes segments as bytes.
"""

import math
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from engine.constants import KIND_PEG, KIND_WALL
from engine.drops.trajectory import Trajectory
from engine.exact import event_log
from engine.exact.outcome import RUNNING
from engine.physics import body
from engine.physics.flight import basis

# Kinds of a segment: the event that begins a flight, or the surface that a curve runs along.
OFF_PEG: Final = KIND_PEG
OFF_WALL: Final = KIND_WALL
LEFT_PEG: Final = 2
LEFT_WALL: Final = 3
DROPPED: Final = 4
UNDER_WAY: Final = 5  # the flight began long ago: this is a later state of it

TOLERANCE = 2e-4
"""m; the largest distance of a curve from the true path: a fiftieth of a pixel at 100 px/m."""

TURN_TOLERANCE = 0.05
"""rad; the same for the angle, which changes at a constant rate in a curve."""

_SAMPLES = 17  # times at which a curve is compared with the path; odd, to include the middle
_SHORTEST = 1e-5  # s; shorter curves along a surface are not halved further

Floats = npt.NDArray[np.float64]


class Segment(msgspec.Struct, frozen=True):
    """A stretch of one ball's path, in SI units: a flight, or a curve if it has a `bend`.

    t: its beginning in s, since the ball's start; in a decoded message since the room's start.
    bend: the parabola's acceleration in m/s^2.
    """

    ball: int
    kind: int
    index: int
    t: float
    x: float
    y: float
    vx: float
    vy: float
    angle: float
    spin: float
    bend: tuple[float, float] | None = None


def later(segment: Segment, s: float, *, gravity: float, drag: float) -> Segment:
    """The same segment, beginning where the ball is s seconds later.

    s may be negative; in a flight -s must be below 1/4 of 1/drag, where the series for it holds.
    """
    phi, psi = s, 0.5 * s * s
    if segment.bend is None:
        _, phi, psi = basis(drag, s)
    ax, ay = segment.bend or (-drag * segment.vx, gravity - drag * segment.vy)
    return msgspec.structs.replace(
        segment,
        t=segment.t + s,
        x=segment.x + segment.vx * s + ax * psi,
        y=segment.y + segment.vy * s + ay * psi,
        vx=segment.vx + ax * phi,
        vy=segment.vy + ay * phi,
        angle=segment.angle + segment.spin * s,
    )


def segments_of(path: Trajectory, ball: int) -> list[Segment]:
    """The segments of an exact drop's whole path, in the order of time."""
    return cut(path, ball, 0, 0, math.inf)[0]


def cut(
    path: Trajectory, ball: int, passed: int, first: int, until: float
) -> tuple[list[Segment], int]:
    """Cut the known rows of a path into segments; returns them and the number of rows cut by now.

    passed: number of the path's rows before those in `path`.
    first: number of rows cut before.
    until: in s. A curve at the end of the known rows may go on beyond them, so it is left for the
    next call, unless it begins before this time.
    """
    cutter = _Cutter(path, ball, passed)
    return cutter.segments, passed + cutter.cut(max(first - passed, 0), until)


class _Cutter:
    """Goes through the rows of the solver's trace and collects segments."""

    def __init__(self, path: Trajectory, ball: int, passed: int) -> None:
        self.path = path
        self.ball = ball
        self.passed = passed
        self.rows = path.segments
        self.starts: list[float] = self.rows[:, body.T].tolist()
        self.ends = [*self.starts[1:], float(path.end[body.T])]
        self.flies: list[bool] = (self.rows[:, event_log.ITEM] == event_log.IN_FLIGHT).tolist()
        self.hits = _hits(path)
        # s; a shorter flight is within the tolerance of a straight line: it may be part of a curve
        self.short = math.sqrt(8.0 * TOLERANCE / max(path.board.gravity, 1e-9))
        self.segments: list[Segment] = []

    def cut(self, first: int, until: float) -> int:
        """Cut the rows from `first` on; returns the first row that is left for later."""
        while first < len(self.rows):
            last = first
            while last < len(self.rows) and not self._is_long_flight(last):
                last += 1
            if last == first:
                self._fly(first)
                last += 1
            elif last == len(self.rows) and self._goes_on and self.starts[first] >= until:
                break
            else:
                self._bend(first, last)
            first = last
        return first

    @property
    def _goes_on(self) -> bool:
        """Whether the path goes on beyond the known rows."""
        return self.path.outcome == RUNNING

    def _is_long_flight(self, row: int) -> bool:
        return self.flies[row] and self.ends[row] - self.starts[row] > self.short

    def _fly(self, row: int) -> None:
        state = self.rows[row]
        kind, index = self._origin(row)
        self._write(kind, index, state, state[body.VX], state[body.VY], state[body.OMEGA])

    def _origin(self, row: int) -> tuple[int, int]:
        """The event that begins a flight: its kind, and the index of the peg or wall."""
        if self.passed + row == 0:
            return DROPPED, 0
        hit = self.hits.get(self.starts[row])
        if hit is not None:
            return hit
        if row == 0:
            return UNDER_WAY, 0
        kind, index = self._surface(row - 1)
        return (LEFT_PEG if kind == OFF_PEG else LEFT_WALL), index

    def _surface(self, row: int) -> tuple[int, int]:
        """The peg or wall that a row runs along, or from which a short hop began."""
        item = int(self.rows[row, event_log.ITEM])
        if item < 0:
            return self.hits.get(self.starts[row], (OFF_PEG, 0))
        pegs = len(self.path.board.pegs)
        return (OFF_PEG, item) if item < pegs else (OFF_WALL, (item - pegs) // 3)

    def _bend(self, first: int, last: int) -> None:
        """Write curves for the rows from `first` to before `last`, as few as fit."""
        begin, end = self.starts[first], self.ends[last - 1]
        if end <= begin:
            return
        if self._fits(first, begin, end):
            return
        if last - first > 1:
            middle = 0.5 * (begin + end)
            cut = min(range(first + 1, last), key=lambda row: abs(self.starts[row] - middle))
            self._bend(first, cut)
            self._bend(cut, last)
        elif self.flies[first]:
            self._fly(first)
        else:
            self._halve(first, begin, end)

    def _halve(self, row: int, begin: float, end: float) -> None:
        middle = 0.5 * (begin + end)
        for low, high in ((begin, middle), (middle, end)):
            if not self._fits(row, low, high, force=high - low < _SHORTEST):
                self._halve(row, low, high)

    def _fits(self, row: int, begin: float, end: float, *, force: bool = False) -> bool:
        """Write the parabola through the path's start, middle and end, if it is near enough.

        The error of such a parabola on a smooth path is 0.008 h^3 times the jerk.
        """
        times = np.linspace(begin, end, _SAMPLES)
        states = self.path.states_at(times)
        h = end - begin
        s = times - begin
        places = states[:, [body.X, body.Y]]
        start, middle, stop = places[0], places[_SAMPLES // 2], places[-1]
        a = (stop - 2.0 * middle + start) * (4.0 / (h * h))
        v = (stop - start) / h - 0.5 * h * a
        drawn = start + np.outer(s, v) + np.outer(0.5 * s * s, a)
        omega = (states[-1, body.THETA] - states[0, body.THETA]) / h
        turned = states[0, body.THETA] + omega * s
        good = (
            np.abs(drawn - places).max() <= TOLERANCE
            and np.abs(turned - states[:, body.THETA]).max() <= TURN_TOLERANCE
        )
        if good or force:
            kind, index = self._surface(row)
            bend = (float(a[0]), float(a[1]))
            self._write(kind, index, states[0], v[0], v[1], omega, bend)
        return bool(good or force)

    def _write(
        self,
        kind: int,
        index: int,
        state: Floats,
        vx: float,
        vy: float,
        omega: float,
        bend: tuple[float, float] | None = None,
    ) -> None:
        t, x, y, angle = (float(state[name]) for name in (body.T, body.X, body.Y, body.THETA))
        self.segments.append(
            Segment(
                self.ball, kind, index, t, x, y, float(vx), float(vy), angle, float(omega), bend
            )
        )


def _hits(path: Trajectory) -> dict[float, tuple[int, int]]:
    """The peg or wall of each bounce, by time."""
    return {
        t: (kind, index)
        for t, (kind, index) in zip(path.events[:, 0].tolist(), path.marks.tolist(), strict=True)
        if kind <= KIND_WALL
    }
