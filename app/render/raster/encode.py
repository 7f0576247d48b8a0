"""Encode pixels as a still picture: PNG, JPEG or WebP."""

import io
from collections.abc import Callable, Mapping
from typing import Final, Literal

from PIL import Image

from plinko.app.errors import InvalidValueError
from plinko.app.render.raster.palette import Palette, Pixels
from plinko.app.render.raster.png import FAST, png

Still = Literal["png", "jpg", "webp"]

QUALITY: Final = 90  # of 100, for JPEG and WebP
LIVE_QUALITY: Final = 80  # of 100, for a JPEG that is visible for a thirtieth of a second


def still(pixels: Pixels, fmt: str) -> bytes:
    """Encode pixels (h, w, 3) in small size; raises InvalidValueError if `fmt` is not in STILLS.

    A PNG gets a palette made for it, which takes a third of the bytes of full colour.
    """
    if fmt not in STILLS:
        names = ", ".join(STILLS)
        raise InvalidValueError(f"format {fmt!r:.40} is not one of {names}", field="format")
    return STILLS[fmt](pixels)


def live_jpg(pixels: Pixels) -> bytes:
    """Encode pixels as JPEG, quickly."""
    return _pillow(pixels, "JPEG", quality=LIVE_QUALITY)


def live_png(pixels: Pixels, palette: Palette) -> bytes:
    """Encode pixels as PNG, quickly, with an existing palette."""
    return png(palette.index(pixels), palette.colours, FAST)


def _png(pixels: Pixels) -> bytes:
    palette = Palette([pixels])
    return png(palette.index(pixels), palette.colours)


def _jpg(pixels: Pixels) -> bytes:
    # Full colour resolution: half of it would fray the edges of red balls on a green plate.
    return _pillow(pixels, "JPEG", quality=QUALITY, subsampling=0, optimize=True)


def _pillow(pixels: Pixels, fmt: str, **options: object) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, fmt, **options)
    return buffer.getvalue()


STILLS: Final[Mapping[str, Callable[[Pixels], bytes]]] = {
    "png": _png,
    "jpg": _jpg,
    "webp": lambda pixels: _pillow(pixels, "WEBP", quality=QUALITY, method=4),
}
