"""GIF bytes, written frame by frame: one palette, and of each frame only what changes."""

import struct
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from PIL import GifImagePlugin, Image

from app.render.raster.palette import UNCHANGED

Pixels = npt.NDArray[np.uint8]

_LOOP_FOR_EVER = b"!\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00"
_KEEP = 1  # disposal: the next frame is painted over this one


def gif(
    first: Pixels, patches: Iterable[tuple[int, int, Pixels]], stays: Sequence[int], palette: Pixels
) -> bytes:
    """Indices (h, w) and what changes in them, as an animation that repeats for ever.

    Each patch is left, top and indices (h, w), where UNCHANGED lets the frame before show. stays:
    how long each frame is shown, ms, one more than there are patches. palette has shape (n, 3).
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
