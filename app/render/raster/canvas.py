"""Anti-aliased painting on an array of pixels: each shape is blended once by its coverage, 0 to 1.

The distance to the edge of a disc, line or box has a closed form. Its coverage therefore needs no
supersampling, and its position is not bound to whole pixels. The centre of the pixel in row i and
column j is (j + 0.5, i + 0.5).
"""

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from plinko.app.render.theme import Colour

Array = npt.NDArray[np.float32]

SUPERSAMPLING = 4  # per axis, for polygons only: 17 levels of coverage along an edge

BAND = 128  # rows per step, so that temporary arrays are small compared with the picture


class Canvas:
    """A picture being painted: float pixels of shape (height, width, 3), 0 to 255.

    clip, shape (height, width): the part of each pixel that may be painted, from 0 to 1.
    """

    def __init__(self, pixels: Array, clip: Array | None = None) -> None:
        self.pixels = pixels
        self.height, self.width = pixels.shape[:2]
        self._clip = clip

    @classmethod
    def blank(cls, width: int, height: int, colour: Colour) -> "Canvas":
        return cls(np.full((height, width, 3), colour, dtype=np.float32))

    def bytes(self) -> npt.NDArray[np.uint8]:
        """The picture as RGB with 8 bits per channel, shape (height, width, 3)."""
        out = np.empty(self.pixels.shape, np.uint8)
        for rows in bands(self.height):
            out[rows] = np.rint(self.pixels[rows])
        return out

    def blend(
        self, left: int, top: int, coverage: Array, colour: Colour | Array, alpha: float = 1.0
    ) -> None:
        """Mix `colour` into the pixels by `coverage` (h, w), whose upper left corner is given.

        `colour` is one colour, or an array of one per pixel.
        """
        height, width = coverage.shape
        x0, y0 = max(left, 0), max(top, 0)
        x1, y1 = min(left + width, self.width), min(top + height, self.height)
        if x0 >= x1 or y0 >= y1:
            return
        inside = (slice(y0 - top, y1 - top), slice(x0 - left, x1 - left))
        cover, target = coverage[inside], self.pixels[y0:y1, x0:x1]
        clip = None if self._clip is None else self._clip[y0:y1, x0:x1]
        paint = colour[inside] if isinstance(colour, np.ndarray) else np.array(colour, np.float32)
        for rows in bands(y1 - y0):
            part, new = target[rows], paint[rows] if paint.ndim == 3 else paint
            strength = cover[rows]
            if clip is not None:
                columns = _filled(clip[rows])
                part, strength = part[:, columns], (strength * clip[rows])[:, columns]
                new = new[:, columns] if paint.ndim == 3 else new
            part += (alpha * strength)[..., None] * (new - part)

    def disc(self, x: float, y: float, radius: float, colour: Colour, alpha: float = 1.0) -> None:
        """Paint a filled circle; px."""
        patch = self.patch(x - radius, y - radius, x + radius, y + radius)
        if patch is not None:
            left, top, xs, ys = patch
            self.blend(left, top, covered(radius - np.hypot(xs - x, ys - y)), colour, alpha)

    def ball(self, x: float, y: float, radius: float, light: "Gradient") -> None:
        """Paint a disc in the colours of a gradient; px."""
        patch = self.patch(x - radius, y - radius, x + radius, y + radius)
        if patch is None:
            return
        left, top, xs, ys = patch
        depth = covered(radius - np.hypot(xs - x, ys - y))
        shades = light.over((xs - x) / radius, (ys - y) / radius)[..., :3]
        self.blend(left, top, depth, shades.astype(np.float32))

    def line(
        self,
        ends: tuple[float, float, float, float],
        width: float,
        colour: Colour,
        alpha: float = 1.0,
    ) -> None:
        """Paint a straight line x1, y1, x2, y2 with round ends; px."""
        x1, y1, x2, y2 = ends
        half = 0.5 * width
        box = (min(x1, x2) - half, min(y1, y2) - half, max(x1, x2) + half, max(y1, y2) + half)
        patch = self.patch(*box)
        if patch is not None:
            left, top, xs, ys = patch
            distance = segment_distance(xs - x1, ys - y1, x2 - x1, y2 - y1)
            self.blend(left, top, covered(half - distance), colour, alpha)

    def box(
        self,
        corners: tuple[float, float, float, float],
        radius: float,
        colour: Colour,
        alpha: float = 1.0,
    ) -> None:
        """Paint a rectangle left, top, right, bottom with rounded corners; px."""
        x0, y0, x1, y1 = corners
        patch = self.patch(x0, y0, x1, y1)
        if patch is None:
            return
        left, top, xs, ys = patch
        if radius == 0.0:
            across = covered(np.minimum(xs - x0, x1 - xs))
            self.blend(left, top, across * covered(np.minimum(ys - y0, y1 - ys)), colour, alpha)
            return
        # The signed distance to the rectangle shrunk by the radius; the edge is at `radius`.
        dx = abs(xs - 0.5 * (x0 + x1)) - (0.5 * (x1 - x0) - radius)
        dy = abs(ys - 0.5 * (y0 + y1)) - (0.5 * (y1 - y0) - radius)
        outside = np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0))
        distance = outside + np.minimum(np.maximum(dx, dy), 0.0)
        coverage = covered(radius - distance)
        self.blend(left, top, coverage, colour, alpha)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        size: float,
        colour: Colour,
        anchor: str = "mm",
        upright: bool = False,
    ) -> None:
        """Write words at (x, y), with `anchor` as in Pillow; `upright` words are read upwards."""
        mask, dx, dy = _text_mask(words, size, anchor)
        if upright:
            mask, dx, dy = np.rot90(mask), dy, -(dx + mask.shape[1])
        self.blend(round(x + dx), round(y + dy), mask, colour)

    def patch(
        self, x0: float, y0: float, x1: float, y1: float
    ) -> tuple[int, int, Array, Array] | None:
        """Clip a box to the picture: left, top, and pixel centres (1, w) and (h, 1); or None."""
        # Clip before converting to int: a shape far outside must not overflow.
        left, right = max(x0 - 1.0, 0.0), min(x1 + 2.0, float(self.width))
        top, bottom = max(y0 - 1.0, 0.0), min(y1 + 2.0, float(self.height))
        if not (left < right and top < bottom):
            return None
        xs = np.arange(int(left), int(right), dtype=np.float32)[None, :] + np.float32(0.5)
        ys = np.arange(int(top), int(bottom), dtype=np.float32)[:, None] + np.float32(0.5)
        return int(left), int(top), xs, ys


def bands(height: int) -> Iterator[slice]:
    """Yield the rows of a picture, BAND at a time."""
    for top in range(0, height, BAND):
        yield slice(top, min(top + BAND, height))


def segment_distance(px: Array, py: Array, dx: float, dy: float) -> Array:
    """Distance of points (px, py) from the segment from the origin to (dx, dy)."""
    length2 = dx * dx + dy * dy
    along = np.clip((px * dx + py * dy) / length2, 0.0, 1.0) if length2 > 0.0 else 0.0
    distance: Array = np.hypot(px - along * dx, py - along * dy)
    return distance


def polygon_coverage(
    polygons: Sequence[Sequence[tuple[float, float]]], width: int, height: int
) -> Array:
    """Coverage (height, width) of the union of polygons in px."""
    # Pillow draws integers. Rounding here makes an edge the same in every band that it crosses.
    fine = [np.trunc(np.array(points) * SUPERSAMPLING).astype(np.int64) for points in polygons]
    coverage = np.empty((height, width), np.float32)
    for rows in bands(height):
        mask = Image.new("L", (width * SUPERSAMPLING, (rows.stop - rows.start) * SUPERSAMPLING))
        draw = ImageDraw.Draw(mask)
        for points in fine:
            corners = points - (0, rows.start * SUPERSAMPLING)
            draw.polygon(corners.ravel().tolist(), fill=255)
        coverage[rows] = np.asarray(mask.reduce(SUPERSAMPLING), np.float32) / np.float32(255.0)
    return coverage


def _filled(clip: Array) -> slice:
    """The columns from the first to the last one that has any coverage."""
    found = np.flatnonzero(clip.any(axis=0))
    return slice(int(found[0]), int(found[-1]) + 1) if len(found) else slice(0, 0)


def covered(depth: npt.NDArray[np.floating[Any]]) -> Array:
    """Coverage of a pixel whose centre lies `depth` px inside a shape (negative: outside)."""
    coverage: Array = np.clip(depth + 0.5, 0.0, 1.0).astype(np.float32)
    return coverage


class Gradient:
    """Colours over the unit disc, between a small circle of light inside and the rim.

    highlight: x, y and radius of the small circle. stops: rows of position (0 at the small circle,
    1 at the rim), red, green, blue (0 to 255) and opacity.
    """

    def __init__(self, highlight: Mapping[str, float], stops: Sequence[tuple[float, ...]]) -> None:
        self._centre = (highlight["x"], highlight["y"])
        self._radius = highlight["radius"]
        self._stops = np.array(stops, np.float64)

    def over(self, x: Any, y: Any) -> npt.NDArray[np.float64]:
        """Red, green, blue and opacity at points of the disc, shape (…, 4).

        The position s of a point p between the circles solves |p - (1 - s) h| = (1 - s) r + s.
        """
        (hx, hy), hr = self._centre, self._radius
        qx, qy = x - hx, y - hy
        a = hx * hx + hy * hy - (1.0 - hr) ** 2
        b = qx * hx + qy * hy - hr * (1.0 - hr)
        c = qx * qx + qy * qy - hr * hr
        # a < 0, because the small circle lies inside the rim; this root is the one wanted.
        place = np.clip((-b - np.sqrt(np.maximum(b * b - a * c, 0.0))) / a, 0.0, 1.0)
        at = self._stops[:, 0]
        return np.stack(
            [np.interp(place, at, self._stops[:, column]) for column in range(1, 5)], axis=-1
        )


@functools.lru_cache(maxsize=32)
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)


def text_width(words: str, size: float) -> float:
    """Width of words in px."""
    return float(_font(max(1, round(size))).getlength(words))


@functools.cache
def _missing() -> bytes:
    """The glyph that the font draws instead of a missing letter."""
    return bytes(_font(20).getmask("\uffff"))


def can_write(words: str) -> bool:
    """Whether the font has all letters of these words."""
    font = _font(20)
    return all(bytes(font.getmask(letter)) != _missing() for letter in set(words))


def _text_mask(words: str, size: float, anchor: str) -> tuple[Array, int, int]:
    """Coverage of words, and the offset of its upper left corner from the anchor."""
    font = _font(max(1, round(size)))
    probe = ImageDraw.Draw(Image.new("L", (1, 1)))
    left, top, right, bottom = map(round, probe.textbbox((0, 0), words, font=font, anchor=anchor))
    mask = Image.new("L", (right - left + 2, bottom - top + 2))
    ImageDraw.Draw(mask).text((1 - left, 1 - top), words, font=font, fill=255, anchor=anchor)
    return np.asarray(mask, dtype=np.float32) / np.float32(255.0), left - 1, top - 1
