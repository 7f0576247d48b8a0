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


class Part(NamedTuple):
    """A part of a picture: its first row and column, and those behind its last; px."""

    top: int
    bottom: int
    left: int
    right: int


@lean_kernel
def part_around(
    least_x: float, most_x: float, least_y: float, most_y: float, reach: float,
    width: int, lowest: int,
) -> Part:  # fmt: skip
    """The part of a picture within `reach` of a box; rows from `lowest` on are not in it."""
    return Part(
        max(floor(least_y - reach), 0),
        min(ceil(most_y + reach), lowest),
        max(floor(least_x - reach), 0),
        min(ceil(most_x + reach), width),
    )


@lean_kernel
def cover_capsule(
    covers: Floats, part: Part, x: float, y: float, dx: float, dy: float,
    thick: float, thinner: float, level: float,
) -> None:  # fmt: skip
    """Raise `covers`, of a part of a picture, to `level` times the coverage of a capsule.

    From (x, y) to (x + dx, y + dy) its radius goes from `thick` to `thick - thinner`, px.
    """
    length2 = dx * dx + dy * dy
    inverse = 1.0 / length2 if length2 > 0.0 else 0.0
    first_row = max(floor(min(y, y + dy) - thick), part.top)
    last_row = min(ceil(max(y, y + dy) + thick) + 1, part.bottom)
    first_column = max(floor(min(x, x + dx) - thick), part.left)
    last_column = min(ceil(max(x, x + dx) + thick) + 1, part.right)
    for row in range(first_row, last_row):
        qy = row + 0.5 - y
        for column in range(first_column, last_column):
            qx = column + 0.5 - x
            along = min(max((qx * dx + qy * dy) * inverse, 0.0), 1.0)
            ex = qx - along * dx
            ey = qy - along * dy
            before = covers[row - part.top, column - part.left]
            reaches = thick - along * thinner + 0.5 - before / level
            distance2 = ex * ex + ey * ey
            if reaches > 0.0 and distance2 < reaches * reaches:
                cover = thick - along * thinner + 0.5 - sqrt(distance2)
                covers[row - part.top, column - part.left] = level * min(cover, 1.0)


@lean_kernel
def blend_covered(pixels: Pixels, part: Part, covers: Floats, colour: Floats, alpha: float) -> None:
    """Mix a colour into a part of a picture as far as that is covered."""
    for row in range(part.top, part.bottom):
        for column in range(part.left, part.right):
            cover = covers[row - part.top, column - part.left]
            if cover > 0.0:
                blend(pixels, row, column, colour, alpha * cover)


@kernel
def paint_trail(
    pixels: Pixels, points: Floats, width: float, lowest: int, colour: Floats, alpha: float
) -> None:
    """A ribbon through `points` (n, 2), px, newest first, that narrows from `width` to nothing.

    Each part is a capsule with two radii; where parts overlap, the larger coverage counts.
    """
    count = points.shape[0]
    if count < 2:
        return
    least_x, most_x, least_y, most_y = bounds(points)
    part = part_around(least_x, most_x, least_y, most_y, 0.5 * width + 1.0, pixels.shape[1], lowest)
    if part.left >= part.right or part.top >= part.bottom:
        return
    covers = np.zeros((part.bottom - part.top, part.right - part.left))
    for piece in range(count - 1):
        x, y = points[piece]
        thick = 0.5 * width * (1.0 - piece / (count - 1))
        thinner = 0.5 * width / (count - 1)
        dx, dy = points[piece + 1, 0] - x, points[piece + 1, 1] - y
        cover_capsule(covers, part, x, y, dx, dy, thick, thinner, 1.0)
    blend_covered(pixels, part, covers, colour, alpha)


@kernel
def paint_line(pixels: Pixels, points: Floats, levels: Floats, coats: Floats) -> None:
    """A line through `points` (n, 2), px, in coats over each other, shape (k, 5): width, opacity
    and colour. Its pieces have `levels` (k, n - 1) of opacity, > 0, in each coat.

    Where pieces overlap, the larger coverage counts.
    """
    least_x, most_x, least_y, most_y = bounds(points)
    for coat in range(coats.shape[0]):
        half = 0.5 * coats[coat, 0]
        part = part_around(
            least_x, most_x, least_y, most_y, half + 1.0, pixels.shape[1], pixels.shape[0]
        )
        if part.left >= part.right or part.top >= part.bottom:
            continue
        covers = np.zeros((part.bottom - part.top, part.right - part.left))
        for piece in range(points.shape[0] - 1):
            x, y = points[piece]
            dx, dy = points[piece + 1, 0] - x, points[piece + 1, 1] - y
            cover_capsule(covers, part, x, y, dx, dy, half, 0.0, levels[coat, piece])
        blend_covered(pixels, part, covers, coats[coat, 2:], coats[coat, 1])


@kernel
def paint_strokes(pixels: Pixels, strokes: Floats, colours: Floats) -> None:
    """Straight lines with round ends, one over the other; one that has no length is a disc.

    strokes, shape (n, 6): ends x, y and x, y, half the width, px, and opacity. colours: (n, 3).
    """
    for i in range(strokes.shape[0]):
        x, y, to_x, to_y, radius, alpha = strokes[i]
        part = part_around(
            min(x, to_x), max(x, to_x), min(y, to_y), max(y, to_y), radius + 1.0,
            pixels.shape[1], pixels.shape[0],
        )  # fmt: skip
        if part.left >= part.right or part.top >= part.bottom:
            continue
        covers = np.zeros((part.bottom - part.top, part.right - part.left))
        cover_capsule(covers, part, x, y, to_x - x, to_y - y, radius, 0.0, 1.0)
        blend_covered(pixels, part, covers, colours[i], alpha)


@inner_kernel
def nearest(colours: Pixels, red: int, green: int, blue: int) -> int:
    """Index of the colour in `colours` (n, 3) nearest to one, by Euclid in sRGB.

    They ascend by green: those whose green alone is farther off than the best so far are left out.
    """
    above = 0
    end = colours.shape[0]
    while above < end:
        middle = (above + end) // 2
        if int(colours[middle, 1]) < green:
            above = middle + 1
        else:
            end = middle
    below = above - 1
    best = 0
    least = 1 << 30
    while True:
        up = int(colours[above, 1]) - green if above < colours.shape[0] else 1 << 15
        down = green - int(colours[below, 1]) if below >= 0 else 1 << 15
        index = above if up <= down else below
        dg = min(up, down)
        if dg * dg >= least:
            return best
        dr = int(colours[index, 0]) - red
        db = int(colours[index, 2]) - blue
        distance = dr * dr + dg * dg + db * db
        if distance < least:
            least = distance
            best = index
        if up <= down:
            above += 1
        else:
            below -= 1


@kernel
def index_pixels(pixels: Pixels, colours: Pixels, keys: Keys, values: Pixels, out: Pixels) -> None:
    """Index of the nearest of `colours`, ascending by green, to each pixel (h, w, 3), into `out`.

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
