"""From pixels to the bytes of a still picture: PNG, JPEG or WebP."""

import io
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from app.errors import InvalidValueError
from app.render.raster.palette import Palette
from app.render.raster.png import FAST, SMALL, png

Pixels = npt.NDArray[np.uint8]

QUALITY: Final = 90  # of 100, of JPEG and WebP
LIVE_QUALITY: Final = 80  # of a JPEG that is seen for a thirtieth of a second


def still(pixels: Pixels, fmt: str) -> bytes:
    """Pixels (h, w, 3) as a picture to keep; `fmt` is one of STILLS, else InvalidValueError.

    A PNG has a palette of the picture's own, which is a third of the bytes.
    """
    if fmt not in STILLS:
        names = ", ".join(STILLS)
        raise InvalidValueError(f"format {fmt!r:.40} is not one of {names}", field="format")
    return STILLS[fmt](pixels)


def live_jpg(pixels: Pixels) -> bytes:
    """Pixels as a JPEG made for speed."""
    return _pillow(pixels, "JPEG", quality=LIVE_QUALITY)


def live_png(pixels: Pixels, palette: Palette) -> bytes:
    """Pixels as a PNG made for speed, in a palette made beforehand."""
    return png(palette.index(pixels), FAST, palette.colours)


def _png(pixels: Pixels) -> bytes:
    palette = Palette([pixels])
    return png(palette.index(pixels), SMALL, palette.colours)


def _jpg(pixels: Pixels) -> bytes:
    # Full colour resolution: halved, it frays red balls on a green plate.
    return _pillow(pixels, "JPEG", quality=QUALITY, subsampling=0, optimize=True)


def _webp(pixels: Pixels) -> bytes:
    return _pillow(pixels, "WEBP", quality=QUALITY, method=4)


def _pillow(pixels: Pixels, fmt: str, **options: object) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, fmt, **options)
    return buffer.getvalue()


STILLS: Final[Mapping[str, Callable[[Pixels], bytes]]] = {
    "png": _png,
    "jpg": _jpg,
    "webp": _webp,
}
"""Formats of still pictures."""

MEDIA_TYPES: Final[Mapping[str, str]] = {
    "png": "image/png",
    "jpg": "image/jpeg",
    "webp": "image/webp",
    "gif": "image/gif",
    "apng": "image/apng",
}
