"""Animate a drop as GIF, WebP, APNG or MP4: the falling ball with its trail, then the result.

Only the surroundings of the ball change from frame to frame, so only they are painted and encoded.
One frame is in memory at a time, however long the fall.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Final, Literal

import numpy as np

from plinko.app.errors import InvalidValueError
from plinko.app.render.parts import balls
from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.caption import paint_caption
from plinko.app.render.parts.view import View, lay_out
from plinko.app.render.raster import gif, png, webp
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.raster.mp4 import mp4
from plinko.app.render.raster.palette import UNCHANGED, Palette, Pixels
from plinko.app.render.still import DEFAULT_WIDTH, drop_pixels
from plinko.app.render.theme import Scheme, at_place, named
from plinko.engine import Drop
from plinko.engine.physics.array_types import Floats

Box = tuple[int, int, int, int]
Animation = Literal["gif", "webp", "apng", "mp4"]
Patch = tuple[int, int, Pixels]
"""Left, top and the pixels (h, w, 3) that replace the previous ones."""

HOLD: Final = 2.0  # s that the result stays before the animation repeats
MOST_FPS: Final = 60
MOST_FPS_GIF: Final = 50
"""A GIF counts hundredths of a second, and browsers show a frame of only one for ten."""

LONGEST: Final = 60.0  # s of a fall that are shown before the result
WEBP_QUALITY: Final = 85  # of 100: no visible blocks around the ball
_SAMPLES: Final = 8  # frames from which the palette learns the moving ball's colours


def drop_animation(
    d: Drop,
    fmt: Animation,
    width: int = DEFAULT_WIDTH,
    fps: int = 30,
    theme: Scheme = "light",
) -> bytes:
    """Animate the drop in `fmt`, one of ANIMATIONS, at real speed and `fps` frames/s.

    A GIF has at most 50 frames/s. The animation ends with the picture of the whole drop for HOLD s.
    Raises InvalidValueError if the format, width, fps or theme is invalid; MissingPartError if the
    format needs a library that is not installed.
    """
    if fmt not in ANIMATIONS:
        names = ", ".join(ANIMATIONS)
        raise InvalidValueError(f"format {fmt!r:.40} is not one of {names}", field="format")
    if not 1 <= fps <= MOST_FPS:
        raise InvalidValueError(
            f"fps {fps} is not from 1 to {MOST_FPS} frames per second", field="fps"
        )
    return ANIMATIONS[fmt](Film(d, width, _rate(fmt, fps), theme))


def frame_count(d: Drop, fmt: str, fps: int) -> int:
    """The number of frames of the drop's animation in `fmt`."""
    return len(_moments(d, _rate(fmt, fps))) + 1


def _rate(fmt: str, fps: int) -> int:
    return min(fps, MOST_FPS_GIF) if fmt == "gif" else fps


def _moments(d: Drop, fps: int) -> Floats:
    """Times in s of the frames that show the fall."""
    return np.arange(max(math.ceil(min(d.duration, LONGEST) * fps), 1)) / fps


class Film:
    """The frames of a drop: the first in full, then the changed patches, and the result."""

    def __init__(self, d: Drop, width: int, fps: int, theme: str) -> None:
        theme = at_place(theme, d.board.name)
        self._drop = d
        self.fps = fps
        self._view = lay_out(d.board, width)
        board = Canvas(board_pixels(d.board, self._view, theme).astype(np.float32))
        paint_caption(board, d, self._view, named(theme), falling=0.0)
        self._board = board.bytes()
        del board  # its floats take four times the memory, and the result needs as much again
        self._style = balls.style_of(d.board.ball.radius * self._view.scale, theme)
        self.times = _moments(d, fps)
        self._points, self._thetas = _trails(d, self._view, self.times)
        self.result = drop_pixels(d, self._view, theme)

    def __len__(self) -> int:
        return len(self.times) + 1

    def first(self) -> Pixels:
        """The complete first frame."""
        return self._begin()[0]

    def _begin(self) -> tuple[Pixels, Box]:
        frame = self._board.copy()
        return frame, self._paint(frame, 0)

    def patches(self) -> Iterator[Patch]:
        """The changed part of each frame after the first; the last is the complete result."""
        frame, dirty = self._begin()
        for number in range(1, len(self.times)):
            x0, y0, x1, y1 = dirty
            frame[y0:y1, x0:x1] = self._board[y0:y1, x0:x1]
            before, dirty = dirty, self._paint(frame, number)
            x0, y0, x1, y1 = _around(before, dirty)
            x0, y0 = x0 & ~1, y0 & ~1  # WebP requires even corners
            yield x0, y0, frame[y0:y1, x0:x1]
        yield 0, 0, self.result

    def samples(self) -> list[Pixels]:
        """Pictures that together contain the colours of all frames."""
        found = [self.result]
        for number in np.linspace(0, len(self.times) - 1, _SAMPLES).astype(int).tolist():
            frame = self._board.copy()
            x0, y0, x1, y1 = self._paint(frame, number)
            found.append(frame[y0:y1, x0:x1].copy())
        return found

    def stays(self, tick: int) -> list[int]:
        """How long each frame stays, in ms: multiples of `tick` ms that add up to real time."""
        step = self.times[1] if len(self.times) > 1 else 0.1
        ends = np.rint(np.append(self.times, self.times[-1] + step) * 1000.0 / tick)
        stays = np.maximum(np.diff(ends), 1.0) * tick
        return [*(int(stay) for stay in stays), round(HOLD * 1000.0)]

    def _paint(self, frame: Pixels, number: int) -> Box:
        """Paint the ball of a frame with its trail; returns their bounding box."""
        points, theta = self._points[number], self._thetas[number : number + 1]
        face = self._view.face
        balls.paint_trail(frame, points, self._style, face)
        balls.paint_balls(frame, points[:1, 0], points[:1, 1], theta, self._style, face)
        return _box(points, 2.0 * self._style.radius + 2.0, self._view)


def _trails(d: Drop, view: View, times: Floats) -> tuple[Floats, Floats]:
    """The trail of each frame in px, shape (frames, points, 2), newest first, and the angles."""
    behind = np.arange(balls.TRAIL_POINTS) * balls.TRAIL_STEP
    states = d.states(np.maximum(times[:, None] - behind, 0.0).ravel())
    points = np.stack([view.px(states["x"]), view.py(states["y"])], axis=-1)
    # A ball that left the board may be anywhere.
    far = 4.0 * max(view.width, view.height)
    shape = (len(times), balls.TRAIL_POINTS)
    return np.clip(points, -far, far).reshape(*shape, 2), states["theta"].reshape(shape)[:, 0]


def _box(points: Floats, reach: float, view: View) -> Box:
    """The part of the picture within `reach` px of the points, at least one pixel."""
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    left, top = (min(max(int(low[i]), 0), size - 1) for i, size in enumerate(view.size))
    right, bottom = (min(max(math.ceil(high[i]), 1), size) for i, size in enumerate(view.size))
    return left, top, max(right, left + 1), max(bottom, top + 1)


def _around(one: Box, two: Box) -> Box:
    return min(one[0], two[0]), min(one[1], two[1]), max(one[2], two[2]), max(one[3], two[3])


def _gif(film: Film) -> bytes:
    palette, first, changes = _indexed(film)
    return gif.gif(first, changes, film.stays(10), palette.colours)


def _apng(film: Film) -> bytes:
    palette, first, changes = _indexed(film)
    return png.apng(first, changes, film.stays(1), palette.colours)


def _indexed(film: Film) -> tuple[Palette, Pixels, Iterator[Patch]]:
    """The palette of all frames, the first frame's indices, and patches of indices.

    There is no dithering, so that still parts do not flicker.
    """
    palette = Palette(film.samples())
    first = palette.index(film.first())

    def changes() -> Iterator[Patch]:
        shown = first.copy()
        for left, top, pixels in film.patches():
            index = palette.index(pixels)
            height, width = index.shape
            before = shown[top : top + height, left : left + width]
            yield left, top, np.where(index == before, np.uint8(UNCHANGED), index)
            before[:] = index

    return palette, first, changes()


def _webp(film: Film) -> bytes:
    return webp.animated(film.first(), film.patches(), film.stays(1), WEBP_QUALITY)


def _frames(film: Film) -> Iterator[Pixels]:
    """Complete frames. The result is repeated for HOLD s, which takes hardly any bytes."""
    frame = film.first()
    yield frame
    for left, top, pixels in film.patches():
        height, width = pixels.shape[:2]
        frame[top : top + height, left : left + width] = pixels
        yield frame
    for _ in range(round(HOLD * film.fps) - 1):
        yield frame


ANIMATIONS: Final[Mapping[str, Callable[[Film], bytes]]] = {
    "gif": _gif,
    "webp": _webp,
    "apng": _apng,
    "mp4": lambda film: mp4(_frames(film), film.fps),
}
