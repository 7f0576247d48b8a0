"""Write animated WebP (RFC 9649): a container with one WebP picture for each changed part.

Pillow's own encoder takes most of its time to find the changes between full frames. Here the caller
knows them.
"""

import io
import struct
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from PIL import Image

from plinko.app.render.raster.palette import Pixels

_ANIMATED: Final = 0x02
_KEEP_AND_REPLACE: Final = 0x02  # a frame stays, and replaces the pixels below without blending
_FOR_EVER: Final = 0
_METHOD: Final = 3  # of 6: more takes longer and gives fewer bytes
_HEAD: Final = 12  # bytes of a file before its first chunk


def animated(
    first: Pixels,
    patches: Iterable[tuple[int, int, Pixels]],
    stays: Sequence[int],
    quality: int,
) -> bytes:
    """Encode a picture (h, w, 3) and patches that change it as an animation that repeats for ever.

    A patch is left and top, both even, and pixels (h, w, 3). stays: durations of the first frame
    and of each patch, in ms. quality: of 100.
    """
    height, width = first.shape[:2]
    parts = [
        _chunk(b"VP8X", struct.pack("<I", _ANIMATED) + _less_one(width) + _less_one(height)),
        _chunk(b"ANIM", struct.pack("<IH", 0, _FOR_EVER)),
        _frame(0, 0, first, stays[0], quality),
    ]
    for (left, top, pixels), stay in zip(patches, stays[1:], strict=True):
        parts.append(_frame(left, top, pixels, stay, quality))
    return _chunk(b"RIFF", b"WEBP" + b"".join(parts))


def _frame(left: int, top: int, pixels: Pixels, stay: int, quality: int) -> bytes:
    height, width = pixels.shape[:2]
    place = _three(left // 2) + _three(top // 2) + _less_one(width) + _less_one(height)
    buffer = io.BytesIO()
    image = Image.fromarray(np.ascontiguousarray(pixels))
    image.save(buffer, "WEBP", quality=quality, method=_METHOD)
    data = place + _three(stay) + bytes([_KEEP_AND_REPLACE]) + buffer.getvalue()[_HEAD:]
    return _chunk(b"ANMF", data)


def _less_one(size: int) -> bytes:
    return _three(size - 1)


def _three(number: int) -> bytes:
    return number.to_bytes(3, "little")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return kind + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)
