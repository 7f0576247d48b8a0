"""Decodes a room's binary messages by docs/protocol.md, without the project's code."""

import math
import struct
from typing import Any

Box = dict[str, float]
Row = dict[str, Any]

SNAPSHOT = (0x50, 1)  # magic, version
SEGMENTS = (0x53, 2)


def snapshot(data: bytes, extent: Box, velocity_scale: float) -> Row:
    """tick, seq and balls of a snapshot; raises ValueError if `data` is not a snapshot."""
    magic, version, count, tick, seq = struct.unpack_from("<BBHII", data)
    if (magic, version) != SNAPSHOT or len(data) != 12 + 12 * count:
        raise ValueError(f"{len(data)} bytes, magic {magic:#x}, version {version}")
    width = extent["x_max"] - extent["x_min"]
    height = extent["y_max"] - extent["y_min"]
    balls = [
        {
            "id": ball,
            "x": x / 65535 * width + extent["x_min"],
            "y": y / 65535 * height + extent["y_min"],
            "theta": angle * (2 * math.pi / 256),
            "vx": vx * velocity_scale,
            "vy": vy * velocity_scale,
            "bounced": bool(flags & 1),
            "asleep": bool(flags & 2),
        }
        for ball, x, y, angle, flags, vx, vy in struct.iter_unpack("<HHHBBhh", data[12:])
    ]
    return {"tick": tick, "seq": seq, "balls": balls}


def segments(data: bytes, hello: Row) -> Row:
    """tick, seq, full, flights and curves of a message; raises ValueError for other data.

    hello: the room's `extent`, `velocity_scale`, `spin_scale` and `tick_rate`.
    """
    magic, version, flights, tick, seq, curves, flags, _ = struct.unpack_from("<BBHIIHBB", data)
    if (magic, version) != SEGMENTS or len(data) != 16 + 18 * flights + 26 * curves:
        raise ValueError(f"{len(data)} bytes, magic {magic:#x}, version {version}")
    middle = 16 + 18 * flights
    return {
        "tick": tick,
        "seq": seq,
        "full": bool(flags & 1),
        "flights": [
            _segment(tick, row, hello) for row in struct.iter_unpack("<HBBHHHhhhH", data[16:middle])
        ],
        "curves": [
            _segment(tick, row, hello) for row in struct.iter_unpack("<HBBHHHhhhHff", data[middle:])
        ],
    }


def _segment(tick: int, row: tuple[Any, ...], hello: Row) -> Row:
    ball, kind, angle, age, x, y, vx, vy, spin, index, *bend = row
    box, scale = hello["extent"], hello["velocity_scale"]
    return {
        "ball": ball,
        "kind": kind,
        "angle": angle * (2 * math.pi / 256),
        "t": (tick - age / 1024) / hello["tick_rate"],
        "x": (2 * x / 65535 - 0.5) * (box["x_max"] - box["x_min"]) + box["x_min"],
        "y": y / 65535 * (box["y_max"] - box["y_min"]) + box["y_min"],
        "vx": vx * 0.5 * scale,
        "vy": vy * 0.5 * scale,
        "spin": spin * hello["spin_scale"],
        "index": index,
        "bend": bend or None,
    }


def place_on_flight(flight: Row, t: float, gravity: float, drag: float) -> tuple[float, float]:
    """x and y (m) of a ball at time t on a flight, by the page's formulas."""
    s = t - flight["t"]
    psi = s * s / 2
    if drag:
        phi = (1 - math.exp(-drag * s)) / drag
        psi = (s - phi) / drag
    return (
        flight["x"] + flight["vx"] * s - drag * flight["vx"] * psi,
        flight["y"] + flight["vy"] * s + (gravity - drag * flight["vy"]) * psi,
    )
