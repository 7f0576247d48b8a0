"""A decoder of snapshots, written after docs/protocol.md, to test the encoder."""

import math

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.protocol.messages import Extent
from plinko.app.protocol.snapshots import BALL, FLAG_ASLEEP, FLAG_BOUNCED, HEADER, MAGIC, VERSION

GRID = 65535  # steps of a coordinate over the extent
TURN = 256  # steps of an angle in a full turn


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
    """Decode a snapshot into SI units."""
    magic, version, count, tick, seq = HEADER.unpack_from(data)
    assert (magic, version) == (MAGIC, VERSION)
    assert len(data) == HEADER.size + count * BALL.itemsize
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
