"""The inner loops of pictures, compiled: balls, trails and palettes, pixel by pixel.

Kernels as the engine's, but that their machine code, `pixels.wasm`, lies beside this file: make.py
makes it. It runs without the GIL, so that a picture in a thread does not hold up the server's loop.
"""

from math import ceil, floor, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from engine.jit.decorator import inner_kernel, kernel, lean_kernel

Floats = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]
Keys = npt.NDArray[np.int32]


@lean_kernel
def blend(pixels: Pixels, row: int, column: int, colour: Floats, alpha: float) -> None:
    """Mix `colour` (r, g, b, 0 to 255) into one pixel."""
    for channel in range(3):
        old = float(pixels[row, column, channel])
        pixels[row, column, channel] = np.uint8(old + alpha * (colour[channel] - old) + 0.5)


@lean_kernel
def disc_cover(distance2: float, radius: float) -> float:
    """Coverage of a pixel whose centre lies sqrt(distance2) px from a disc's; the root is rare."""
    if distance2 >= (radius + 0.5) * (radius + 0.5):
        return 0.0
    if radius > 0.5 and distance2 <= (radius - 0.5) * (radius - 0.5):
        return 1.0
    return radius + 0.5 - sqrt(distance2)


@inner_kernel
def paint_disc(
    pixels: Pixels, x: float, y: float, radius: float, lowest: int, colour: Floats, alpha: float
) -> None:
    """A flat disc; px. Rows from `lowest` on stay as they are."""
    left = max(floor(x - radius), 0)
    right = min(ceil(x + radius) + 1, pixels.shape[1])
    top = max(floor(y - radius), 0)
    bottom = min(ceil(y + radius) + 1, lowest)
    for row in range(top, bottom):
        dy = row + 0.5 - y
        for column in range(left, right):
            dx = column + 0.5 - x
            cover = disc_cover(dx * dx + dy * dy, radius)
            if cover > 0.0:
                blend(pixels, row, column, colour, alpha * cover)


class BallPaint(NamedTuple):
    """What balls of one size and theme are painted with; lengths are parts of a ball's radius.

    Colours have shape (3,), from 0 to 255. The band reaches `half_band` to both sides of a
    diameter. gloss has shape (n, n, 4): colour and opacity over the square from -1 to 1 radii.
    """

    body: Floats
    band: Floats
    half_band: float
    shadow: Floats
    shadow_across: float
    shadow_down: float
    shadow_alpha: float
    gloss: Floats


X, Y, COSINE, SINE, RADIUS = range(5)
"""Columns of a ball: its centre and radius in px, and the direction of its band."""


@inner_kernel
def paint_ball(pixels: Pixels, ball: Floats, lowest: int, paint: BallPaint) -> None:
    """A disc with a band across it, turned, and a gloss that does not turn; ball: shape (5,)."""
    x, y, radius = ball[X], ball[Y], ball[RADIUS]
    cosine, sine = ball[COSINE], ball[SINE]
    body, band, gloss = paint.body, paint.band, paint.gloss
    left = max(floor(x - radius), 0)
    right = min(ceil(x + radius) + 1, pixels.shape[1])
    top = max(floor(y - radius), 0)
    bottom = min(ceil(y + radius) + 1, lowest)
    last = gloss.shape[0] - 1
    grid = 0.5 * last / radius
    half_band = paint.half_band * radius
    for row in range(top, bottom):
        dy = row + 0.5 - y
        for column in range(left, right):
            dx = column + 0.5 - x
            cover = disc_cover(dx * dx + dy * dy, radius)
            if cover <= 0.0:
                continue
            across = abs(cosine * dy - sine * dx)
            striped = min(max(half_band + 0.5 - across, 0.0), 1.0)
            i = min(max(int((dy + radius) * grid + 0.5), 0), last)
            j = min(max(int((dx + radius) * grid + 0.5), 0), last)
            shine = gloss[i, j, 3]
            for channel in range(3):
                matte = body[channel] + striped * (band[channel] - body[channel])
                colour = matte + shine * (gloss[i, j, channel] - matte)
                old = float(pixels[row, column, channel])
                pixels[row, column, channel] = np.uint8(old + cover * (colour - old) + 0.5)


@kernel
def paint_balls(pixels: Pixels, balls: Floats, lowest: int, paint: BallPaint) -> None:
    """Balls, shape (n, 5), with their shadows, later ones over earlier ones; far-off ones left out.

    Rows from `lowest` on stay as they are.
    """
    for i in range(balls.shape[0]):
        x, y, radius = balls[i, X], balls[i, Y], balls[i, RADIUS]
        reach = 2.0 * radius
        if not (-reach < x < pixels.shape[1] + reach and -reach < y < pixels.shape[0] + reach):
            continue
        dx, dy = paint.shadow_across * radius, paint.shadow_down * radius
        paint_disc(pixels, x + dx, y + dy, radius, lowest, paint.shadow, paint.shadow_alpha)
        paint_ball(pixels, balls[i], lowest, paint)


@inner_kernel
def bounds(points: Floats) -> tuple[float, float, float, float]:
    """The smallest and the largest x, then y, of points (n, 2), n > 0."""
    least_x = most_x = points[0, 0]
    least_y = most_y = points[0, 1]
    for i in range(1, points.shape[0]):
        least_x = min(least_x, points[i, 0])
        most_x = max(most_x, points[i, 0])
        least_y = min(least_y, points[i, 1])
        most_y = max(most_y, points[i, 1])
    return least_x, most_x, least_y, most_y


@kernel
def paint_trail(
    pixels: Pixels, points: Floats, width: float, lowest: int, colour: Floats, alpha: float
) -> None:
    """A ribbon through `points` (n, 2), px, newest first, that narrows from `width` to nothing.

    Each part is a capsule with two radii; where parts overlap, the larger coverage counts.
    """
    count = points.shape[0]
    reach = 0.5 * width + 1.0
    least_x, most_x, least_y, most_y = bounds(points)
    left = max(floor(least_x - reach), 0)
    right = min(ceil(most_x + reach), pixels.shape[1])
    top = max(floor(least_y - reach), 0)
    bottom = min(ceil(most_y + reach), lowest)
    if left >= right or top >= bottom or count < 2:
        return
    covers = np.zeros((bottom - top, right - left))
    for part in range(count - 1):
        x, y = points[part]
        dx = points[part + 1, 0] - x
        dy = points[part + 1, 1] - y
        thick = 0.5 * width * (1.0 - part / (count - 1))
        thinner = 0.5 * width / (count - 1)
        length2 = dx * dx + dy * dy
        inverse = 1.0 / length2 if length2 > 0.0 else 0.0
        first_row = max(floor(min(y, y + dy) - thick), top)
        last_row = min(ceil(max(y, y + dy) + thick) + 1, bottom)
        first_column = max(floor(min(x, x + dx) - thick), left)
        last_column = min(ceil(max(x, x + dx) + thick) + 1, right)
        for row in range(first_row, last_row):
            qy = row + 0.5 - y
            for column in range(first_column, last_column):
                qx = column + 0.5 - x
                along = min(max((qx * dx + qy * dy) * inverse, 0.0), 1.0)
                ex = qx - along * dx
                ey = qy - along * dy
                reaches = thick - along * thinner + 0.5 - covers[row - top, column - left]
                distance2 = ex * ex + ey * ey
                if reaches > 0.0 and distance2 < reaches * reaches:
                    cover = thick - along * thinner + 0.5 - sqrt(distance2)
                    covers[row - top, column - left] = min(cover, 1.0)
    for row in range(top, bottom):
        for column in range(left, right):
            cover = covers[row - top, column - left]
            if cover > 0.0:
                blend(pixels, row, column, colour, alpha * cover)


@inner_kernel
def nearest(colours: Pixels, red: int, green: int, blue: int) -> int:
    """Index of the colour in `colours` (n, 3) nearest to one, by Euclid in sRGB."""
    best = 0
    least = 1 << 30
    for index in range(colours.shape[0]):
        dr = int(colours[index, 0]) - red
        dg = int(colours[index, 1]) - green
        db = int(colours[index, 2]) - blue
        distance = dr * dr + dg * dg + db * db
        if distance < least:
            least = distance
            best = index
    return best


@kernel
def index_pixels(pixels: Pixels, colours: Pixels, keys: Keys, values: Pixels, out: Pixels) -> None:
    """Index of the nearest of `colours` to each pixel (h, w, 3), into `out` (h, w).

    keys and values, shape (n,), n a power of two, remember what was found, keys -1 where nothing
    was: a table of hashes, probed a few places on.
    """
    mask = keys.shape[0] - 1
    for row in range(pixels.shape[0]):
        last = -1
        for column in range(pixels.shape[1]):
            red = int(pixels[row, column, 0])
            green = int(pixels[row, column, 1])
            blue = int(pixels[row, column, 2])
            key = (red << 16) | (green << 8) | blue
            if key == last:
                out[row, column] = out[row, column - 1]
                continue
            last = key
            # Fibonacci hashing: middle bits of a product with 2^32 / golden ratio.
            slot = ((key * 2654435769) >> 16) & mask
            probes = 0
            while probes < 8 and keys[slot] >= 0 and keys[slot] != key:
                slot = (slot + 1) & mask
                probes += 1
            if keys[slot] == key:
                out[row, column] = values[slot]
                continue
            found = nearest(colours, red, green, blue)
            out[row, column] = found
            if keys[slot] < 0:
                values[slot] = found
                keys[slot] = key
