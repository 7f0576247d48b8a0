"""Write PNG and APNG quickly, with the same filter for all rows.

Pillow tries every filter on every row. This takes four times as long as the compression itself, and
does not make these pictures smaller.
"""

import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.render.raster.palette import UNCHANGED

Pixels = npt.NDArray[np.uint8]

_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_FILTER_NONE, _FILTER_UP = 0, 2
_TRUECOLOUR, _INDEXED = 2, 3
_KEEP, _OVER = 0, 1  # a frame stays visible, and the next one is painted over it

FAST, SMALL = 1, 6
"""zlib levels: for a picture that is shown once, and for one that is stored."""


def png(pixels: Pixels, level: int = SMALL, palette: Pixels | None = None) -> bytes:
    """Encode RGB pixels (h, w, 3), or indices (h, w) into a palette (n, 3), as PNG."""
    return b"".join(
        [
            _SIGNATURE,
            _header(pixels, palette),
            _chunk(b"IDAT", _packed(pixels, level)),
            _chunk(b"IEND", b""),
        ]
    )


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


def _header(pixels: Pixels, palette: Pixels | None) -> bytes:
    height, width = pixels.shape[:2]
    kind = _TRUECOLOUR if palette is None else _INDEXED
    header = _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0))
    return header if palette is None else header + _chunk(b"PLTE", palette.tobytes())


def _control(number: int, left: int, top: int, pixels: Pixels, stay: int) -> bytes:
    """An fcTL chunk: a frame's position and duration; it is painted over the previous frame."""
    height, width = pixels.shape[:2]
    fields = (number, width, height, left, top, stay, 1000, _KEEP, _OVER)
    return _chunk(b"fcTL", struct.pack(">IIIIIHHBB", *fields))


def _packed(pixels: Pixels, level: int) -> bytes:
    """Compress the rows with their filter bytes. A filter would not help for indices."""
    height = pixels.shape[0]
    flat = pixels.reshape(height, -1)
    rows = np.empty((height, flat.shape[1] + 1), np.uint8)
    if pixels.ndim == 2:
        rows[:, 0] = _FILTER_NONE
        rows[:, 1:] = flat
    else:
        rows[:, 0] = _FILTER_UP
        rows[0, 1:] = flat[0]
        np.subtract(flat[1:], flat[:-1], out=rows[1:, 1:])
    return zlib.compress(rows.data, level)


def _chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(data, zlib.crc32(kind))
    return b"".join([struct.pack(">I", len(data)), kind, data, struct.pack(">I", check)])
