"""A drop as it falls: an animated GIF or WebP of the ball with its trail, and the result.

Only the ball's surroundings change from frame to frame, so only they are painted again.
"""

import io
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from app.errors import InvalidValueError
from app.render.board import board_canvas
from app.render.canvas import Canvas
from app.render.caption import paint_caption
from app.render.path import paint_ball, paint_ghost
from app.render.picture import DEFAULT_WIDTH, drop_canvas
from app.render.view import View, lay_out
from app.theme import Theme, named
from engine import Drop

Pixels = npt.NDArray[np.uint8]

HOLD: Final = 2.0  # s that the result stays before the animation starts again
MOST_PIXELS: Final = 250_000_000  # of all frames, in memory at once while Pillow encodes them
MOST_FPS: Final = 60
TRAIL: Final = 6  # ghosts behind the ball
TRAIL_STEP: Final = 1 / 50  # s between them
WEBP_QUALITY: Final = 85  # of 100: no visible blocks around the ball


@dataclass(frozen=True)
class Patch:
    """What a frame shows instead of the empty board: pixels (h, w, 3) with the corner at (x, y)."""

    x: int
    y: int
    pixels: Pixels


def drop_animation(
    d: Drop, fmt: str, width: int = DEFAULT_WIDTH, fps: int = 30, theme: str = "light"
) -> bytes:
    """The drop as an animation in `fmt`, `gif` or `webp`, at real speed and `fps` frames/s.

    Raises InvalidValueError naming a format, a width, an fps or a theme that is none.
    """
    if fmt not in _ENCODERS:
        raise InvalidValueError(f"format {fmt!r} is not gif or webp", field="format")
    if not 1 <= fps <= MOST_FPS:
        raise InvalidValueError(f"fps {fps} is not from 1 to {MOST_FPS}", field="fps")
    view = lay_out(d.board, width)
    board = board_canvas(d.board, view, theme)
    paint_caption(board, d, view, named(theme), ended=False)
    # A fall too long for the memory is shown from its start, and its result in any case.
    most = max(MOST_PIXELS // (view.width * view.height), 1)
    times = np.arange(max(min(math.ceil(d.duration * fps), most), 1)) / fps
    patches = _patches(d, view, named(theme), board, times)
    last = drop_canvas(d, view, theme).image()
    return _ENCODERS[fmt](board.image(), patches, last, times)


def _patches(
    d: Drop, view: View, theme: Theme, board: Canvas, times: npt.NDArray[np.float64]
) -> Iterator[Patch]:
    """The surroundings of the ball at `times`."""
    behind = np.arange(TRAIL, -1, -1) * TRAIL_STEP
    for time in times:
        states = d.states(np.maximum(time - behind, 0.0))
        x, y, width, height = _surroundings(d, view, states)
        if width <= 0 or height <= 0:  # the ball is outside of the picture
            yield Patch(0, 0, np.rint(board.pixels[:1, :1]).astype(np.uint8))
            continue
        canvas = Canvas(board.pixels[y : y + height, x : x + width].copy())
        part = view.cut(x, y, width, height)
        for number, state in enumerate(states[:-1], 1):
            paint_ghost(canvas, d.board, part, theme, state, 0.4 * number / TRAIL)
        paint_ball(canvas, d.board, part, theme, states[-1])
        yield Patch(x, y, np.rint(canvas.pixels).astype(np.uint8))


def _surroundings(d: Drop, view: View, states: npt.NDArray[np.void]) -> tuple[int, int, int, int]:
    """Left, top, width and height in px of what holds the ball in all `states`."""
    reach = max(d.board.ball.radius * view.scale, 2.0) + 2.0
    xs, ys = view.px(states["x"]), view.py(states["y"])
    left, right = max(xs.min() - reach, 0.0), min(xs.max() + reach, float(view.width))
    top, bottom = max(ys.min() - reach, 0.0), min(ys.max() + reach, float(view.height))
    return int(left), int(top), math.ceil(right) - int(left), math.ceil(bottom) - int(top)


def _durations(times: npt.NDArray[np.float64], tick: int) -> list[int]:
    """How long each frame stays, ms, in whole ticks that add up to real time; then the result's."""
    step = times[1] if len(times) > 1 else 0.1
    ends = np.rint(np.append(times, times[-1] + step) * 1000.0 / tick)
    stays = np.maximum(np.diff(ends), 1.0) * tick
    return [*(int(stay) for stay in stays), round(HOLD * 1000.0)]


def _webp(
    board: Image.Image,
    patches: Iterator[Patch],
    last: Image.Image,
    times: npt.NDArray[np.float64],
) -> bytes:
    frames = []
    for patch in patches:
        frame = board.copy()
        frame.paste(Image.fromarray(patch.pixels), (patch.x, patch.y))
        frames.append(frame)
    # No key frames: each is a whole picture, and twelve times the bytes in all.
    never = {"kmin": 1 << 30, "kmax": (1 << 30) + 1}
    options = {"quality": WEBP_QUALITY, "method": 2, **never}
    return _saved([*frames, last], _durations(times, 1), "WEBP", options)


def _gif(
    board: Image.Image,
    patches: Iterator[Patch],
    last: Image.Image,
    times: npt.NDArray[np.float64],
) -> bytes:
    """One palette for all frames; where the board is bare, every frame has the same indices."""
    palette = _palette(last)
    bare = np.asarray(board)
    # Dithered once: what flickers from frame to frame is seen, and costs bytes.
    index = np.asarray(board.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG))
    frames = []
    for patch in (*patches, Patch(0, 0, np.asarray(last))):
        height, width = patch.pixels.shape[:2]
        inside = (slice(patch.y, patch.y + height), slice(patch.x, patch.x + width))
        painted = Image.fromarray(patch.pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        same = (patch.pixels == bare[inside]).all(axis=-1)
        frame = index.copy()
        frame[inside] = np.where(same, index[inside], np.asarray(painted))
        frames.append(Image.fromarray(frame, "P"))
        frames[-1].putpalette(palette.getpalette() or [])
    return _saved(frames, _durations(times, 10), "GIF", {"optimize": False, "disposal": 1})


def _palette(picture: Image.Image) -> Image.Image:
    """255 colours for a drop (one is left for 'unchanged'), with enough for the small ball."""
    return picture.quantize(255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _saved(
    frames: list[Image.Image], durations: list[int], fmt: str, options: dict[str, Any]
) -> bytes:
    buffer = io.BytesIO()
    frames[0].save(
        buffer,
        fmt,
        save_all=True,
        append_images=frames[1:],
        duration=durations,
        loop=0,
        **options,
    )
    return buffer.getvalue()


_ENCODERS: Final[Mapping[str, Callable[..., bytes]]] = {"gif": _gif, "webp": _webp}
