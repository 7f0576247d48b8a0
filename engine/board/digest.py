"""A board's content digest: SHA-256 over one canonical byte string.

The bytes, all little-endian, with no padding:

    ascii   "plinko-board/1\\n"
    u32     length of the name in bytes, then the name in UTF-8
    f64 x4  width, height, gravity, drag
    f64 x4  ball radius, density, restitution, friction
    u32     number of pegs, then f64 x3 each: x, y, radius
    f64 x2  peg restitution, friction
    u32     number of walls, then f64 x4 each: x1, y1, x2, y2
    f64 x2  wall restitution, friction
    f64     bins y
    u32     number of edges, then f64 each
    u32     number of multipliers, then f64 each
    f64 x3  drop x, y, jitter
    u32     number of slots, then f64 each
    f64     reach, if it or the aim is not 0, or if there are labels
    f64     aim, if it is not 0, or if there are labels
    u32     number of labels, if there are any, then for each, with no label as two empty texts:
            u32 and UTF-8   length of the text in bytes, then the text
            u32 and ASCII   length of the colour, then the colour: "#rrggbb" or nothing

A label names the prize of a bin, on which the players agreed, so the digest covers labels too.
Negative zero is written as zero, because both are the same place. The order of pegs and walls
matters, because impacts refer to them by index.
"""

import hashlib
from array import array
from collections.abc import Iterable
from sys import byteorder
from typing import Final

from plinko.engine.board.fields import BoardFields
from plinko.engine.board.parts import Label

MAGIC: Final = b"plinko-board/1\n"


def _floats(values: Iterable[float]) -> bytes:
    raw = array("d", (value + 0.0 for value in values))  # -0.0 + 0.0 is 0.0
    if byteorder == "big":
        raw.byteswap()
    return raw.tobytes()


def _text(text: str) -> bytes:
    raw = text.encode()
    return _count(len(raw)) + raw


def _labels(labels: tuple[Label | None, ...]) -> bytes:
    texts = ((label.text, label.colour or "") if label else ("", "") for label in labels)
    return _count(len(labels)) + b"".join(_text(text) for pair in texts for text in pair)


def _count(n: int) -> bytes:
    return n.to_bytes(4, "little")


def encode(board: BoardFields) -> bytes:
    """Return the canonical bytes of `board`, as laid out at the top of this file."""
    ball, bins, zone = board.ball, board.bins, board.drop
    pegs, walls = board.peg_material, board.wall_material
    return b"".join(
        (
            MAGIC,
            _text(board.name),
            _floats((board.width, board.height, board.gravity, board.drag)),
            _floats((ball.radius, ball.density, ball.restitution, ball.friction)),
            _count(len(board.pegs)),
            _floats(v for p in board.pegs for v in (p.x, p.y, p.radius)),
            _floats((pegs.restitution, pegs.friction)),
            _count(len(board.walls)),
            _floats(v for w in board.walls for v in (w.x1, w.y1, w.x2, w.y2)),
            _floats((walls.restitution, walls.friction)),
            _floats((bins.y,)),
            _count(len(bins.edges)),
            _floats(bins.edges),
            _count(len(bins.multipliers)),
            _floats(bins.multipliers),
            _floats((zone.x, zone.y, zone.jitter)),
            _count(len(zone.slots)),
            _floats(zone.slots),
            _floats((zone.reach,) if zone.reach or zone.aim or bins.labels else ()),
            _floats((zone.aim,) if zone.aim or bins.labels else ()),
            _labels(bins.labels) if bins.labels else b"",
        ),
    )


def digest(board: BoardFields) -> str:
    """Return the SHA-256 of `encode(board)`, 64 hex digits."""
    return hashlib.sha256(encode(board)).hexdigest()
