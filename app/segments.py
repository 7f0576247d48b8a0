"""A ball's path in pieces that a client can draw by itself: one for each flight between bounces.

Pure. A flight is exact: its state at the start, from which gravity and drag do the rest. Where a
ball lies on a surface, or hops too low to see, one parabola stands for as much of the path as it
fits to within TOLERANCE. docs/protocol.md describes every byte.
"""

import math
import struct
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from app.errors import MalformedError
from engine.constants import KIND_PEG, KIND_WALL
from engine.kernels.flight import basis
from engine.kernels.log import IN_FLIGHT, ITEM, OMEGA, PX, PY, THETA, VX, VY, T
from engine.trajectory import Trajectory

MAGIC = 0x53
VERSION = 1
HEADER = struct.Struct("<BBHIHBB")  # magic, version, flights, tick, curves, flags, 0
FULL = 1  # flag: the current piece of every ball in flight, whatever came before

_COMMON = [
    ("id", "<u2"),
    ("kind", "u1"),
    ("angle", "u1"),
    ("t", "<f4"),
    ("x", "<f4"),
    ("y", "<f4"),
    ("vx", "<f4"),
    ("vy", "<f4"),
    ("spin", "<i2"),
    ("index", "<u2"),
]
FLIGHT = np.dtype(_COMMON)
CURVE = np.dtype([*_COMMON, ("ax", "<f4"), ("ay", "<f4")])

# Kinds of a piece: what it begins with, or what it runs along.
OFF_PEG: Final = KIND_PEG
OFF_WALL: Final = KIND_WALL
LEFT_PEG: Final = 2
LEFT_WALL: Final = 3
DROPPED: Final = 4

TOLERANCE = 2e-4
"""m; how far a curve may be from the true path: a fiftieth of a pixel at 100 px/m."""

TURN_TOLERANCE = 0.05
"""rad; the same for the angle, which a curve turns evenly."""

_SAMPLES = 17  # instants at which a curve is compared with the path; odd: the middle is one
_SHORTEST = 1e-5  # s; a stretch of a ride is not halved below it
_TURN = 256
_TOP = 32767

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Pieces:
    """A whole path: flights, shape (n,) of FLIGHT, and curves, shape (m,) of CURVE, by time."""

    flights: npt.NDArray[np.void]
    curves: npt.NDArray[np.void]


def pieces_of(path: Trajectory, ball: int, spin_scale: float) -> Pieces:
    """The pieces of an exact drop's path; `spin_scale` is the rad/s of one step of `spin`."""
    return _Cutter(path, ball, spin_scale).cut()


class _Cutter:
    """Walks along the solver's segments and writes down pieces."""

    def __init__(self, path: Trajectory, ball: int, spin_scale: float) -> None:
        self.path = path
        self.ball = ball & 0xFFFF
        self.spin_scale = spin_scale
        self.rows = path.segments
        self.starts: list[float] = self.rows[:, T].tolist()
        self.ends = [*self.starts[1:], float(path.end[T])]
        self.flies: list[bool] = (self.rows[:, ITEM] == IN_FLIGHT).tolist()
        self.hits = _hits(path)
        # A flight that strays less than the tolerance from a straight line may be part of a curve.
        self.short = math.sqrt(8.0 * TOLERANCE / max(path.board.gravity, 1e-9))
        self.flights: list[tuple[float, ...]] = []
        self.curves: list[tuple[float, ...]] = []

    def cut(self) -> Pieces:
        first = 0
        while first < len(self.rows):
            last = first
            while last < len(self.rows) and not self._is_long_flight(last):
                last += 1
            if last == first:
                self._fly(first)
                last += 1
            else:
                self._bend(first, last)
            first = last
        return Pieces(np.array(self.flights, FLIGHT), np.array(self.curves, CURVE))

    def _is_long_flight(self, row: int) -> bool:
        return self.flies[row] and self.ends[row] - self.starts[row] > self.short

    def _fly(self, row: int) -> None:
        state = self.rows[row]
        kind, index = self._origin(row)
        self.flights.append(self._record(kind, index, state, state[VX], state[VY], state[OMEGA]))

    def _origin(self, row: int) -> tuple[int, int]:
        """What a flight begins with: the kind and the index of the peg or wall."""
        if row == 0:
            return DROPPED, 0
        hit = self.hits.get(self.starts[row])
        if hit is not None:
            return hit
        kind, index = self._surface(row - 1)
        return (LEFT_PEG if kind == OFF_PEG else LEFT_WALL), index

    def _surface(self, row: int) -> tuple[int, int]:
        """The peg or wall that a segment runs along; for a short hop, what it hopped off."""
        item = int(self.rows[row, ITEM])
        if item < 0:
            return self.hits.get(self.starts[row], (OFF_PEG, 0))
        pegs = len(self.path.board.pegs)
        return (OFF_PEG, item) if item < pegs else (OFF_WALL, (item - pegs) // 3)

    def _bend(self, first: int, last: int) -> None:
        """Curves for the segments from `first` up to `last`, as few as fit."""
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
        """Write down the parabola through the path's start, middle and end, if it is near enough.

        A quadratic through three points of a smooth path errs by 0.008 h^3 times its jerk.
        """
        times = np.linspace(begin, end, _SAMPLES)
        states = self.path.states_at(times)
        h = end - begin
        s = times - begin
        places = states[:, [PX, PY]]
        start, middle, stop = places[0], places[_SAMPLES // 2], places[-1]
        a = (stop - 2.0 * middle + start) * (4.0 / (h * h))
        v = (stop - start) / h - 0.5 * h * a
        drawn = start + np.outer(s, v) + np.outer(0.5 * s * s, a)
        omega = (states[-1, THETA] - states[0, THETA]) / h
        turned = states[0, THETA] + omega * s
        good = (
            np.abs(drawn - places).max() <= TOLERANCE
            and np.abs(turned - states[:, THETA]).max() <= TURN_TOLERANCE
        )
        if good or force:
            kind, index = self._surface(row)
            record = self._record(kind, index, states[0], v[0], v[1], omega)
            self.curves.append((*record, float(a[0]), float(a[1])))
        return bool(good or force)

    def _record(
        self, kind: int, index: int, state: Floats, vx: float, vy: float, omega: float
    ) -> tuple[float, ...]:
        turns = state[THETA] / (2.0 * math.pi)
        angle = round((turns - math.floor(turns)) * _TURN) % _TURN
        spin = round(min(max(omega / self.spin_scale, -_TOP), _TOP))
        place = (float(state[T]), float(state[PX]), float(state[PY]))
        return self.ball, kind, angle, *place, float(vx), float(vy), spin, index & 0xFFFF


def _hits(path: Trajectory) -> dict[float, tuple[int, int]]:
    """Bounces off pegs and walls by their time."""
    return {
        t: (kind, index)
        for t, (kind, index) in zip(path.events[:, 0].tolist(), path.marks.tolist(), strict=True)
        if kind <= KIND_WALL
    }


class SegmentStream:
    """What of each ball's path is to be sent at which tick of a room; `now` is the room's tick."""

    def __init__(self, tick_rate: int, spin_scale: float, now: int) -> None:
        self._rate = tick_rate
        self._spin_scale = spin_scale
        self._next = now + 1
        self._due: dict[int, tuple[list[bytes], list[bytes]]] = {}
        self._paths: dict[int, list[tuple[int, bool, bytes]]] = {}

    def add(self, ball: int, start_tick: int, path: Trajectory, now: int) -> None:
        """Follow a ball; of one that started before `now` only what is to come will be sent."""
        pieces = pieces_of(path, ball, self._spin_scale)
        rows: list[tuple[int, bool, bytes]] = []
        for array in (pieces.flights, pieces.curves):
            curved = array.dtype == CURVE
            for record in array:
                # The tick that ends when or after the piece begins, as for its bounce's event.
                tick = start_tick + math.ceil(float(record["t"]) * self._rate)
                rows.append((tick, curved, record.tobytes()))
        self._paths[ball] = sorted(rows, key=lambda row: row[0])
        for tick, curved, record in self._paths[ball]:
            if tick > now or start_tick == now:
                self._due.setdefault(max(tick, now + 1), ([], []))[curved].append(record)

    def forget(self, ball: int) -> None:
        """A ball has landed."""
        self._paths.pop(ball, None)

    def take(self, tick: int) -> bytes | None:
        """The frame of all that became due up to this tick; None when nothing did."""
        flights: list[bytes] = []
        curves: list[bytes] = []
        for due in range(self._next, tick + 1):
            new_flights, new_curves = self._due.pop(due, ((), ()))
            flights += new_flights
            curves += new_curves
        self._next = tick + 1
        return _frame(tick, flights, curves, 0) if flights or curves else None

    def full(self, tick: int) -> bytes:
        """The frame of the piece that every ball is on at this tick."""
        flights: list[bytes] = []
        curves: list[bytes] = []
        for rows in self._paths.values():
            current = [row for row in rows if row[0] <= tick] or rows[:1]
            _, curved, record = current[-1]
            (curves if curved else flights).append(record)
        return _frame(tick, flights, curves, FULL)


def _frame(tick: int, flights: list[bytes], curves: list[bytes], flags: int) -> bytes:
    header = HEADER.pack(MAGIC, VERSION, len(flights), tick & 0xFFFFFFFF, len(curves), flags, 0)
    return b"".join((header, *flights, *curves))


class Segments(msgspec.Struct, frozen=True):
    """A decoded frame: its tick, whether it is full, and rows of FLIGHT and CURVE."""

    tick: int
    full: bool
    flights: npt.NDArray[np.void]
    curves: npt.NDArray[np.void]


def decode_segments(data: bytes) -> Segments:
    """A frame's bytes as records.

    Raises MalformedError naming the byte count, magic or version that is wrong.
    """
    if len(data) < HEADER.size:
        raise MalformedError(f"segments of {len(data)} bytes have no whole header")
    magic, version, flights, tick, curves, flags, _ = HEADER.unpack_from(data)
    if magic != MAGIC or version != VERSION:
        raise MalformedError(f"magic {magic:#x}, version {version} is no frame of segments 1")
    middle = HEADER.size + flights * FLIGHT.itemsize
    if len(data) != middle + curves * CURVE.itemsize:
        raise MalformedError(f"{len(data)} bytes do not hold {flights} flights, {curves} curves")
    return Segments(
        tick,
        bool(flags & FULL),
        np.frombuffer(data, FLIGHT, flights, HEADER.size),
        np.frombuffer(data, CURVE, curves, middle),
    )


def pose_at(
    piece: np.void, t: float, *, gravity: float, drag: float, spin_scale: float
) -> tuple[float, float, float]:
    """x, y (m) and angle (rad) on a decoded piece at t seconds after the ball's start."""
    x, y, vx, vy = (float(piece[name]) for name in ("x", "y", "vx", "vy"))
    s = t - float(piece["t"])
    angle = float(piece["angle"]) * (2.0 * math.pi / _TURN) + float(piece["spin"]) * spin_scale * s
    if "ax" in (piece.dtype.names or ()):
        ax, ay = float(piece["ax"]), float(piece["ay"])
        return x + vx * s + 0.5 * ax * s * s, y + vy * s + 0.5 * ay * s * s, angle
    _, _, psi = basis(drag, s)
    return x + vx * s - drag * vx * psi, y + vy * s + (gravity - drag * vy) * psi, angle
