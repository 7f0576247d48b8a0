"""Decoders of binary messages, written after docs/protocol.md, to test the encoders."""

import math

import msgspec
import numpy as np
import numpy.typing as npt

from app.errors import MalformedError
from app.protocol.messages import PROTOCOL_VERSION, Extent
from app.protocol.path import Segment
from app.protocol.segments import CURVE, FLIGHT, FULL, VERSION, Scale
from app.protocol.segments import HEADER as SEGMENTS_HEADER
from app.protocol.segments import MAGIC as SEGMENTS_MAGIC
from app.protocol.snapshots import BALL, FLAG_ASLEEP, FLAG_BOUNCED, HEADER, MAGIC
from engine.physics.flight import basis

GRID = 65535  # steps of a coordinate over the extent
TURN = 256  # steps of an angle in a full turn
STEPS = 1024  # steps of a segment's age in one tick


class Snapshot(msgspec.Struct, frozen=True):
    """A decoded snapshot; `balls` has the fields id x y theta vx vy (SI units), bounced, asleep."""

    tick: int
    seq: int
    balls: npt.NDArray[np.void]


DECODED = np.dtype(
    [
        ("id", "u2"),
        ("x", "f8"),
        ("y", "f8"),
        ("theta", "f8"),
        ("vx", "f8"),
        ("vy", "f8"),
        ("bounced", "?"),
        ("asleep", "?"),
    ]
)


def decode_snapshot(data: bytes, extent: Extent, velocity_scale: float) -> Snapshot:
    """Decode a snapshot into SI units.

    Raises MalformedError if byte count, magic or version is wrong.
    """
    if len(data) < HEADER.size:
        raise MalformedError(f"a snapshot of {len(data)} bytes has no whole header")
    magic, version, count, tick, seq = HEADER.unpack_from(data)
    if magic != MAGIC or version != PROTOCOL_VERSION:
        raise MalformedError(f"magic {magic:#x}, version {version} is not a snapshot of version 1")
    if len(data) != HEADER.size + count * BALL.itemsize:
        raise MalformedError(f"{len(data)} bytes do not hold {count} balls")
    raw = np.frombuffer(data, BALL, count, HEADER.size)
    balls = np.empty(count, DECODED)
    balls["id"] = raw["id"]
    balls["x"] = raw["x"] / GRID * (extent.x_max - extent.x_min) + extent.x_min
    balls["y"] = raw["y"] / GRID * (extent.y_max - extent.y_min) + extent.y_min
    balls["theta"] = raw["angle"] * (2.0 * math.pi / TURN)
    balls["vx"] = raw["vx"] * velocity_scale
    balls["vy"] = raw["vy"] * velocity_scale
    balls["bounced"] = (raw["flags"] & FLAG_BOUNCED) != 0
    balls["asleep"] = (raw["flags"] & FLAG_ASLEEP) != 0
    return Snapshot(tick, seq, balls)


class Segments(msgspec.Struct, frozen=True):
    """A decoded message of segments: straight `flights` and bent `curves`.

    seq: the number of the room's events until now. Times are seconds since the room's start; a
    ball's number is given modulo 65536.
    """

    tick: int
    seq: int
    full: bool
    flights: list[Segment]
    curves: list[Segment]


def decode_segments(data: bytes, scale: Scale) -> Segments:
    """Decode a message of segments.

    Raises MalformedError if byte count, magic or version is wrong.
    """
    if len(data) < SEGMENTS_HEADER.size:
        raise MalformedError(f"segments of {len(data)} bytes have no whole header")
    magic, version, flights, tick, seq, curves, flags, _ = SEGMENTS_HEADER.unpack_from(data)
    if magic != SEGMENTS_MAGIC or version != VERSION:
        raise MalformedError(f"magic {magic:#x}, version {version} is no message of segments 2")
    middle = SEGMENTS_HEADER.size + flights * FLIGHT.size
    if len(data) != middle + curves * CURVE.size:
        raise MalformedError(f"{len(data)} bytes do not hold {flights} flights, {curves} curves")
    return Segments(
        tick,
        seq,
        bool(flags & FULL),
        [
            _segment(tick, row, scale)
            for row in FLIGHT.iter_unpack(data[SEGMENTS_HEADER.size : middle])
        ],
        [_segment(tick, row, scale) for row in CURVE.iter_unpack(data[middle:])],
    )


def _segment(tick: int, row: tuple[float, ...], scale: Scale) -> Segment:
    ball, kind, angle, age, x, y, vx, vy, spin, index, *bend = row
    box = scale.extent
    return Segment(
        ball=int(ball),
        kind=int(kind),
        index=int(index),
        t=(tick - age / STEPS) / scale.tick_rate,
        x=(2.0 * x / GRID - 0.5) * (box.x_max - box.x_min) + box.x_min,
        y=y / GRID * (box.y_max - box.y_min) + box.y_min,
        vx=vx * 0.5 * scale.velocity_scale,
        vy=vy * 0.5 * scale.velocity_scale,
        angle=angle * (2.0 * math.pi / TURN),
        spin=spin * scale.spin_scale,
        bend=(bend[0], bend[1]) if bend else None,
    )


def pose_at(
    segment: Segment, t: float, *, gravity: float, drag: float
) -> tuple[float, float, float]:
    """x, y (m) and angle (rad) of a ball on a segment at t, in s since the room's start."""
    s = t - segment.t
    psi = 0.5 * s * s if segment.bend else basis(drag, s)[2]
    ax, ay = segment.bend or (-drag * segment.vx, gravity - drag * segment.vy)
    return (
        segment.x + segment.vx * s + ax * psi,
        segment.y + segment.vy * s + ay * psi,
        segment.angle + segment.spin * s,
    )
