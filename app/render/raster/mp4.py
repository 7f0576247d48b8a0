"""A film as MP4: H.264 by PyAV, the optional extra `video`, in a form that all browsers play."""

from collections.abc import Iterator
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from app.errors import MissingPartError

Pixels = npt.NDArray[np.uint8]

_BT709: Final = 1  # of ITU-T H.273: what players take high resolution for
_CODING: Final = {"crf": "24", "preset": "veryfast", "x264-params": "mbtree=0"}
"""No visible blocks around the ball. Macroblock-tree rate control would take 0.6 of the bytes for
the same noise, but x264 165's is not the same from run to run, on one thread too (4 of 36 films
differed by a few bytes; without it 0 of 138)."""

_LARGE: Final = 1 << 20  # pixels
_OF_LARGE: Final = {"tune": "zerolatency"}
"""Twice the bytes; but otherwise dozens of frames are kept, with 6 bytes and more a pixel."""


def mp4(frames: Iterator[Pixels], fps: int) -> bytes:
    """Frames (h, w, 3), `fps` a second, as a file.

    Half the pixels of H.264 have a colour of their own, so sides are even: an odd one has its last
    row or column twice. Raises MissingPartError where PyAV is not installed.
    """
    if find_spec("av") is None:
        raise MissingPartError(
            "films as MP4 need PyAV, which is not installed: pip install 'plinko-server[video]'",
            field="format",
        )
    import av  # noqa: PLC0415 - it may not be installed

    # The index comes first, so that a browser plays before it has all; for that the library reads
    # the file again.
    with TemporaryDirectory(prefix="plinko-") as directory:
        path = Path(directory, "film.mp4")
        with av.open(path, "w", options={"movflags": "+faststart"}) as container:
            stream: Any = None
            for number, pixels in enumerate(frames):
                if stream is None:
                    stream = _stream(container, _even(pixels), fps)
                picture = av.VideoFrame.from_ndarray(_even(pixels), format="rgb24").reformat(
                    format="yuv420p", dst_colorspace=_BT709
                )
                picture.pts, picture.time_base = number, Fraction(1, fps)
                container.mux(stream.encode(picture))
            container.mux(stream.encode())
        return path.read_bytes()


def _stream(container: Any, first: Pixels, fps: int) -> Any:
    height, width = first.shape[:2]
    large = height * width > _LARGE
    options = {**_CODING, **_OF_LARGE} if large else _CODING
    stream = container.add_stream("libx264", rate=fps, options=options)
    stream.height, stream.width = height, width
    stream.pix_fmt = "yuv420p"
    context = stream.codec_context
    context.thread_count = 1  # as many threads, as many versions of the same film
    context.colorspace = context.color_primaries = context.color_trc = _BT709
    return stream


def _even(pixels: Pixels) -> Pixels:
    height, width = pixels.shape[:2]
    if height % 2 == width % 2 == 0:
        return np.ascontiguousarray(pixels)
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
