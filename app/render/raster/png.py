"""Write PNG and APNG quickly, with a palette and without a filter.

Pillow tries every filter on every row. This takes four times as long as the compression itself, and
does not make these pictures smaller: a filter does not help for indices.
"""

import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from plinko.app.render.raster.palette import UNCHANGED, Pixels

_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_INDEXED = 3
_KEEP, _OVER = 0, 1  # a frame stays visible, and the next one is painted over it

FAST, SMALL = 1, 6
"""zlib levels: for a picture that is shown once, and for one that is stored."""


def png(index: Pixels, palette: Pixels, level: int = SMALL) -> bytes:
    """Encode indices (h, w) into a palette (n, 3) as PNG."""
    data = _chunk(b"IDAT", _packed(index, level))
    return b"".join([_SIGNATURE, _header(index, palette), data, _chunk(b"IEND", b"")])


def apng(
    first: Pixels,
    patches: Iterable[tuple[int, int, Pixels]],
    stays: Sequence[int],
    palette: Pixels,
) -> bytes:
    """Encode indices (h, w) and patches that change them as an animated PNG, repeated for ever.

    A patch is left, top and indices (h, w); at UNCHANGED the previous frame stays visible. stays:
    durations of the first frame and of each patch, in ms. palette: shape (n, 3).
    """
    colours = np.zeros((UNCHANGED + 1, 3), np.uint8)
    colours[: len(palette)] = palette
    opacities = b"\xff" * UNCHANGED + b"\0"
    parts = [_SIGNATURE, _header(first, colours), _chunk(b"tRNS", opacities)]
    parts.append(_chunk(b"acTL", struct.pack(">II", len(stays), 0)))
    parts += [_control(0, 0, 0, first, stays[0]), _chunk(b"IDAT", _packed(first, SMALL))]
    number = 1
    for (left, top, pixels), stay in zip(patches, stays[1:], strict=True):
        parts.append(_control(number, left, top, pixels, stay))
        data = struct.pack(">I", number + 1) + _packed(pixels, SMALL)
        parts.append(_chunk(b"fdAT", data))
        number += 2
    return b"".join([*parts, _chunk(b"IEND", b"")])


def _header(index: Pixels, palette: Pixels) -> bytes:
    height, width = index.shape
    header = _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, _INDEXED, 0, 0, 0))
    return header + _chunk(b"PLTE", palette.tobytes())


def _control(number: int, left: int, top: int, pixels: Pixels, stay: int) -> bytes:
    """An fcTL chunk: a frame's position and duration; it is painted over the previous frame."""
    height, width = pixels.shape[:2]
    fields = (number, width, height, left, top, stay, 1000, _KEEP, _OVER)
    return _chunk(b"fcTL", struct.pack(">IIIIIHHBB", *fields))


def _packed(index: Pixels, level: int) -> bytes:
    """Compress the rows, each after the byte 0, which says that it has no filter."""
    return zlib.compress(np.pad(index, ((0, 0), (1, 0))).data, level)


def _chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(data, zlib.crc32(kind))
    return b"".join([struct.pack(">I", len(data)), kind, data, struct.pack(">I", check)])
