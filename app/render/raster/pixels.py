"""Compiled inner loops of pictures, pixel by pixel: balls, trails, lines and palettes.

These are kernels like the engine's. make.py compiles them to `pixels.wasm` in this folder. They run
without the GIL, so that drawing in a thread does not block the server's event loop.
"""

from math import ceil, floor, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.jit.decorator import inner_kernel, kernel, lean_kernel

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
    """Coverage of a pixel whose centre is sqrt(distance2) px from a disc's centre.

    Only pixels on the edge need the root.
    """
    if distance2 >= (radius + 0.5) * (radius + 0.5):
        return 0.0
    if radius > 0.5 and distance2 <= (radius - 0.5) * (radius - 0.5):
        return 1.0
    return radius + 0.5 - sqrt(distance2)


@inner_kernel
def paint_disc(
    pixels: Pixels, x: float, y: float, radius: float, lowest: int, colour: Floats, alpha: float
) -> None:
    """Paint a flat disc; px. Rows from `lowest` on do not change."""
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
    """The appearance of balls of one size and theme; lengths are parts of a ball's radius.

    Colours have shape (3,), from 0 to 255. The band reaches `half_band` to each side of a diameter.
    gloss: colour and opacity over the square from -1 to 1 radii, shape (n, n, 4).
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
    """Paint a disc with a turned band and a gloss that does not turn; ball: shape (5,)."""
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
    """Paint balls, shape (n, 5), with their shadows, each over the previous ones.

    Balls outside the picture are skipped. Rows from `lowest` on do not change.
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
    """The smallest and largest x, then the smallest and largest y, of points (n, 2), n > 0."""
    least_x = most_x = points[0, 0]
    least_y = most_y = points[0, 1]
    for i in range(1, points.shape[0]):
        least_x = min(least_x, points[i, 0])
        most_x = max(most_x, points[i, 0])
        least_y = min(least_y, points[i, 1])
        most_y = max(most_y, points[i, 1])
    return least_x, most_x, least_y, most_y


class Part(NamedTuple):
    """A part of a picture: rows `top` to `bottom - 1`, columns `left` to `right - 1`."""

    top: int
    bottom: int
    left: int
    right: int


@lean_kernel
def part_around(
    least_x: float, most_x: float, least_y: float, most_y: float, reach: float,
    width: int, lowest: int,
) -> Part:  # fmt: skip
    """The part of a picture within `reach` px of a box, without rows from `lowest` on."""
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
    """Raise `covers`, the coverage of a part, to at least `level` times that of a capsule.

    The capsule's radius goes from `thick` at (x, y) to `thick - thinner` at (x + dx, y + dy), px.
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
    """Mix a colour into a part of a picture by its coverage."""
    for row in range(part.top, part.bottom):
        for column in range(part.left, part.right):
            cover = covers[row - part.top, column - part.left]
            if cover > 0.0:
                blend(pixels, row, column, colour, alpha * cover)


@kernel
def paint_trail(
    pixels: Pixels, points: Floats, width: float, lowest: int, colour: Floats, alpha: float
) -> None:
    """Paint a ribbon through `points` (n, 2), px, newest first, narrowing from `width` to 0.

    Each piece is a capsule with two radii; where pieces overlap, the larger coverage counts.
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
    """Paint a line through `points` (n, 2), px, in coats over each other.

    coats, shape (k, 5): width, opacity and colour. levels, shape (k, n - 1): opacity of each piece
    in each coat, > 0. Where pieces overlap, the larger coverage counts.
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
    """Paint straight lines with round ends, each over the previous ones; without length, discs.

    strokes, shape (n, 6): x, y of both ends and half the width, in px, and opacity. colours: shape
    (n, 3).
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
    """The index of the nearest of `colours` (n, 3), by Euclidean distance in sRGB.

    The colours are sorted by green. The search goes from the nearest green up and down, and ends
    when green alone differs by more than the best distance found.
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
    """Write the index of the nearest of `colours`, sorted by green, to each pixel (h, w, 3).

    keys and values, shape (n,), n a power of two, are a hash table of indices found before, with
    linear probing over a few slots; an empty slot has the key -1.
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
