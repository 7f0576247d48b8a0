"""Decodes a room's binary messages by docs/protocol.md, without the project's code."""

import bisect
import math
import struct
from typing import Any

Box = dict[str, float]
Row = dict[str, Any]

SNAPSHOT = (0x50, 1)  # magic, version
PATH = (0x46, 1)


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


def paths(data: bytes) -> list[Row]:
    """ball and knots of each path in a message; raises ValueError if `data` is no such message."""
    found: list[Row] = []
    at = 0
    while at < len(data) or not found:
        magic, version, _, count, ball = struct.unpack_from("<BBHIQ", data, at)
        begin, at = at + 16, at + 16 + 28 * count
        if (magic, version) != PATH or count == 0 or len(data) < at:
            raise ValueError(f"{len(data)} bytes, magic {magic:#x}, version {version}")
        rows = struct.iter_unpack("<7f", data[begin:at])
        names = ("t", "x", "y", "angle", "ax", "ay", "hit")
        found.append({"ball": ball, "knots": [dict(zip(names, row, strict=True)) for row in rows]})
    return found


def pose(knots: list[Row], t: float, drag: float) -> tuple[float, float, float]:
    """x and y (m) and angle (rad) of a ball t seconds after its start, by the page's formulas."""
    after = max(1, min(bisect.bisect([knot["t"] for knot in knots], t), len(knots) - 1))
    a, b = knots[after - 1], knots[after]
    (phi, psi), (whole, part) = basis(drag, t - a["t"]), basis(drag, b["t"] - a["t"])
    u = phi / whole
    x, y = (a[i] + (b[i] - a[i]) * u + a["a" + i] * (psi - part * u) for i in "xy")
    return x, y, a["angle"] + (b["angle"] - a["angle"]) * (t - a["t"]) / (b["t"] - a["t"])


def basis(drag: float, s: float) -> tuple[float, float]:
    """The page's phi and psi."""
    if drag * s < 1e-6:
        return s, s * s / 2
    phi = -math.expm1(-drag * s) / drag
    return phi, (s - phi) / drag
