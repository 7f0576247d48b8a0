"""Frames of `?stream=segments`: pieces of paths as bytes, and which are to be sent when. Pure.

docs/protocol.md describes every byte. Times on the wire are in steps of a tick; a piece is told
from where the ball is at such a step, so that rounding its time moves nothing.
"""

import math
import struct
from dataclasses import dataclass

import msgspec

from app.errors import MalformedError
from app.protocol.curves import UNDER_WAY, Piece, later, pieces_of
from app.protocol.messages import Extent
from engine.drops.trajectory import Trajectory
from engine.physics.flight import basis

MAGIC = 0x53
VERSION = 2
HEADER = struct.Struct("<BBHIIHBB")  # magic, version, flights, tick, seq, curves, flags, 0
FULL = 1  # flag: the current piece of every ball in flight, whatever came before

FLIGHT = struct.Struct("<HBBHHHhhhH")  # id, kind, angle, age, x, y, vx, vy, spin, index
CURVE = struct.Struct("<HBBHHHhhhHff")  # the same and ax, ay

_TURN = 256
_TOP = 32767
_GRID = 65535
_STEPS = 1024  # of a tick: a piece may begin up to half a step, 8 us at 60 Hz, too soon or late
_OLDEST = 63  # ticks; a piece that began longer ago is told from there


@dataclass(frozen=True, slots=True)
class Scale:
    """What the numbers of a frame mean: the hello tells it all. SI units, ticks a second."""

    extent: Extent
    velocity_scale: float
    spin_scale: float
    tick_rate: int
    gravity: float
    drag: float

    def law(self) -> dict[str, float]:
        """Gravity in m/s^2 and drag in 1/s by name."""
        return {"gravity": self.gravity, "drag": self.drag}


@dataclass(frozen=True, slots=True)
class _Due:
    """A piece on its way: the room's tick at which it is due, and when it begins, in ticks."""

    tick: int
    begin: float
    piece: Piece


class SegmentStream:
    """What of each ball's path is to be sent at which tick of a room; `now` is the room's tick."""

    def __init__(self, scale: Scale, now: int) -> None:
        self._scale = scale
        self._next = now + 1
        self._paths: dict[int, list[_Due]] = {}
        self._due: dict[int, list[_Due]] = {}

    def add(self, ball: int, start_tick: int, path: Trajectory, now: int) -> None:
        """Follow a ball: what begins after tick `now`, or at a start that is now, will be sent."""
        rate = self._scale.tick_rate
        # The tick that ends when or after the piece begins, as for its bounce's event.
        rows = [
            _Due(start_tick + math.ceil(piece.t * rate), start_tick + piece.t * rate, piece)
            for piece in pieces_of(path, ball)
        ]
        self._paths[ball] = rows
        for row in rows:
            if row.tick > now or start_tick == now:
                self._due.setdefault(max(row.tick, now + 1), []).append(row)

    def forget(self, ball: int) -> None:
        """A ball has landed."""
        self._paths.pop(ball, None)

    def take(self, tick: int, seq: int) -> bytes | None:
        """The frame of all that became due up to this tick; None when nothing did."""
        rows: list[_Due] = []
        for due in range(self._next, tick + 1):
            rows += self._due.pop(due, ())
        self._next = tick + 1
        return _frame(tick, seq, rows, 0, self._scale) if rows else None

    def full(self, tick: int, seq: int) -> bytes:
        """The frame of the piece that every ball is on at this tick."""
        current = []
        for rows in self._paths.values():
            begun = [row for row in rows if row.tick <= tick] or rows[:1]
            current.append(begun[-1])
        return _frame(tick, seq, current, FULL, self._scale)


def _frame(tick: int, seq: int, rows: list[_Due], flags: int, scale: Scale) -> bytes:
    flights = [_record(tick, row, scale) for row in rows if row.piece.bend is None]
    curves = [_record(tick, row, scale) for row in rows if row.piece.bend is not None]
    stamp = (tick & 0xFFFFFFFF, seq & 0xFFFFFFFF)
    header = HEADER.pack(MAGIC, VERSION, len(flights), *stamp, len(curves), flags, 0)
    return b"".join((header, *flights, *curves))


def _record(tick: int, row: _Due, scale: Scale) -> bytes:
    """A piece as bytes in a frame of this tick."""
    age = round((tick - row.begin) * _STEPS)
    kind = row.piece.kind
    if age > _OLDEST * _STEPS:
        age = _OLDEST * _STEPS
        kind = UNDER_WAY
    moved = (tick - age / _STEPS - row.begin) / scale.tick_rate
    piece = later(row.piece, moved, **scale.law())
    box = scale.extent
    turns = piece.angle / (2.0 * math.pi)
    values = (
        piece.ball & 0xFFFF,
        kind,
        round((turns - math.floor(turns)) * _TURN) % _TURN,
        age,
        _clamp((0.5 * (piece.x - box.x_min) / (box.x_max - box.x_min) + 0.25) * _GRID, 0, _GRID),
        _clamp((piece.y - box.y_min) / (box.y_max - box.y_min) * _GRID, 0, _GRID),
        _clamp(piece.vx / (0.5 * scale.velocity_scale), -_TOP, _TOP),
        _clamp(piece.vy / (0.5 * scale.velocity_scale), -_TOP, _TOP),
        _clamp(piece.spin / scale.spin_scale, -_TOP, _TOP),
        piece.index & 0xFFFF,
    )
    return FLIGHT.pack(*values) if piece.bend is None else CURVE.pack(*values, *piece.bend)


def _clamp(value: float, low: int, high: int) -> int:
    return round(min(max(value, low), high))


class Segments(msgspec.Struct, frozen=True):
    """A decoded frame: its tick, the room's events so far, whether it is full, and its pieces.

    Times count from the room's start; balls are known by their number modulo 65536.
    """

    tick: int
    seq: int
    full: bool
    flights: list[Piece]
    curves: list[Piece]


def decode_segments(data: bytes, scale: Scale) -> Segments:
    """A frame's bytes as pieces.

    Raises MalformedError naming the byte count, magic or version that is wrong.
    """
    if len(data) < HEADER.size:
        raise MalformedError(f"segments of {len(data)} bytes have no whole header")
    magic, version, flights, tick, seq, curves, flags, _ = HEADER.unpack_from(data)
    if magic != MAGIC or version != VERSION:
        raise MalformedError(f"magic {magic:#x}, version {version} is no frame of segments 2")
    middle = HEADER.size + flights * FLIGHT.size
    if len(data) != middle + curves * CURVE.size:
        raise MalformedError(f"{len(data)} bytes do not hold {flights} flights, {curves} curves")
    return Segments(
        tick,
        seq,
        bool(flags & FULL),
        [_piece(tick, row, scale) for row in FLIGHT.iter_unpack(data[HEADER.size : middle])],
        [_piece(tick, row, scale) for row in CURVE.iter_unpack(data[middle:])],
    )


def _piece(tick: int, row: tuple[float, ...], scale: Scale) -> Piece:
    ball, kind, angle, age, x, y, vx, vy, spin, index, *bend = row
    box = scale.extent
    return Piece(
        ball=int(ball),
        kind=int(kind),
        index=int(index),
        t=(tick - age / _STEPS) / scale.tick_rate,
        x=(2.0 * x / _GRID - 0.5) * (box.x_max - box.x_min) + box.x_min,
        y=y / _GRID * (box.y_max - box.y_min) + box.y_min,
        vx=vx * 0.5 * scale.velocity_scale,
        vy=vy * 0.5 * scale.velocity_scale,
        angle=angle * (2.0 * math.pi / _TURN),
        spin=spin * scale.spin_scale,
        bend=(bend[0], bend[1]) if bend else None,
    )


def pose_at(piece: Piece, t: float, *, gravity: float, drag: float) -> tuple[float, float, float]:
    """x, y (m) and angle (rad) on a piece at t, counted as its own start is."""
    s = t - piece.t
    psi = 0.5 * s * s if piece.bend else basis(drag, s)[2]
    ax, ay = piece.bend or (-drag * piece.vx, gravity - drag * piece.vy)
    return (
        piece.x + piece.vx * s + ax * psi,
        piece.y + piece.vy * s + ay * psi,
        piece.angle + piece.spin * s,
    )
