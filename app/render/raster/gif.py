"""Write animated GIF: one palette for all frames, and only the changed part of each frame."""

import struct
from collections.abc import Iterable, Sequence

import numpy as np
from PIL import GifImagePlugin, Image

from plinko.app.render.raster.palette import UNCHANGED, Pixels

_LOOP_FOR_EVER = b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"
_KEEP = 1  # disposal method: the next frame is painted over this one


def gif(
    first: Pixels, patches: Iterable[tuple[int, int, Pixels]], stays: Sequence[int], palette: Pixels
) -> bytes:
    """Encode indices (h, w) and patches that change them as an animation that repeats for ever.

    A patch is left, top and indices (h, w); at UNCHANGED the previous frame stays visible. stays:
    durations of the first frame and of each patch, in ms. palette: shape (n, 3).
    """
    height, width = first.shape
    colours = np.zeros((256, 3), np.uint8)
    colours[: len(palette)] = palette
    parts = [b"GIF89a", struct.pack("<HHBBB", width, height, 0xF7, 0, 0), colours.tobytes()]
    parts.append(_LOOP_FOR_EVER)
    parts += _frame(0, 0, first, stays[0])
    for (left, top, pixels), stay in zip(patches, stays[1:], strict=True):
        parts += _frame(left, top, pixels, stay)
    return b"".join([*parts, b";"])


def _frame(left: int, top: int, pixels: Pixels, stay: int) -> list[bytes]:
    image = Image.fromarray(pixels, "P")
    return GifImagePlugin.getdata(
        image, (left, top), duration=stay, transparency=UNCHANGED, disposal=_KEEP
    )
