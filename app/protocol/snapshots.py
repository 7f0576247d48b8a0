"""The binary messages of `?stream=snapshots`: places and velocities of all balls. Pure.

docs/protocol.md describes every byte; tests/golden/snapshots.json has examples.
"""

import math
import struct

import numpy as np
import numpy.typing as npt

from plinko.app.protocol.messages import Extent
from plinko.engine import Board

MAGIC = 0x50
VERSION = 1
HEADER = struct.Struct("<BBHII")  # magic, version, balls, tick, number of the last event

BALL = np.dtype(
    [
        ("id", "<u2"),
        ("x", "<u2"),
        ("y", "<u2"),
        ("angle", "u1"),
        ("flags", "u1"),
        ("vx", "<i2"),
        ("vy", "<i2"),
    ]
)
FLAG_BOUNCED = 1  # the ball hit something since the previous snapshot
FLAG_ASLEEP = 2  # the ball rests until something touches it

_GRID = 65535  # steps of a 16-bit coordinate across the extent
_TURN = 256  # steps of the angle in a full turn
_TOP = 32767  # largest 16-bit velocity


def velocity_scale_of(board: Board, extent: Extent) -> float:
    """m/s in one step of a velocity: the least power of two from 1/1024 on that suffices.

    A ball that falls from rest by h gains at most sqrt(2 g h); twice that leaves room for impacts
    with other balls.
    """
    top = 2.0 * math.sqrt(2.0 * board.gravity * (extent.y_max - extent.y_min))
    scale = 1.0 / 1024.0
    while _TOP * scale < top:
        scale *= 2.0
    return scale


def encode_snapshot(
    tick: int,
    seq: int,
    bodies: npt.NDArray[np.void],
    bounced: npt.NDArray[np.bool_],
    extent: Extent,
    velocity_scale: float,
    asleep: npt.NDArray[np.bool_] | None = None,
) -> bytes:
    """The bytes of a snapshot.

    bodies: shape (n,), with the fields id, x, y, theta, vx, vy in SI units.
    bounced, asleep: shape (n,); None if balls never sleep in the room.

    `tick` and `seq` are taken modulo 2^32, ids modulo 2^16. Values outside the extent or the
    velocity range are clamped.
    """
    count = len(bodies)
    balls = np.empty(count, BALL)
    balls["id"] = bodies["id"] & 0xFFFF
    balls["x"] = _grid(bodies["x"], extent.x_min, extent.x_max)
    balls["y"] = _grid(bodies["y"], extent.y_min, extent.y_max)
    turns = bodies["theta"] * (1.0 / (2.0 * math.pi))
    balls["angle"] = np.rint((turns - np.floor(turns)) * _TURN).astype(np.int64) & (_TURN - 1)
    balls["flags"] = np.where(bounced, FLAG_BOUNCED, 0)
    if asleep is not None:
        balls["flags"] |= np.where(asleep, FLAG_ASLEEP, 0).astype(np.uint8)
    balls["vx"] = np.clip(np.rint(bodies["vx"] / velocity_scale), -_TOP, _TOP)
    balls["vy"] = np.clip(np.rint(bodies["vy"] / velocity_scale), -_TOP, _TOP)
    header = HEADER.pack(MAGIC, VERSION, count, tick & 0xFFFFFFFF, seq & 0xFFFFFFFF)
    return header + balls.tobytes()


def _grid(values: npt.NDArray[np.float64], low: float, high: float) -> npt.NDArray[np.float64]:
    scaled: npt.NDArray[np.float64] = np.rint((values - low) * (_GRID / (high - low)))
    return np.clip(scaled, 0, _GRID)
