"""Encode a film as MP4 that all browsers play: H.264 by PyAV, of the optional extra `video`."""

from collections.abc import Iterator
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from plinko.app.render.raster.palette import Pixels
from plinko.engine.errors import MissingPartError

_BT709: Final = 1  # ITU-T H.273's code of the colour space that players assume for high resolution
_CODING: Final = {"crf": "24", "preset": "veryfast", "x264-params": "mbtree=0"}
"""With this crf there are no visible blocks around the ball. Macroblock-tree rate control would
need 0.6 times the bytes for the same noise, but that of x264 165 is not reproducible even on one
thread: 4 of 36 films differed by a few bytes, and without it 0 of 138."""

_LARGE: Final = 1 << 20  # pixels
_OF_LARGE: Final = {"tune": "zerolatency"}
"""Twice the bytes. Otherwise x264 keeps dozens of frames, with 6 bytes or more per pixel."""


def mp4(frames: Iterator[Pixels], fps: int) -> bytes:
    """Encode frames (h, w, 3) at `fps` frames/s.

    H.264 halves the colours' resolution and so needs even sides: of an odd side the last row or
    column is repeated. Raises MissingPartError if PyAV is not installed.
    """
    if find_spec("av") is None:
        raise MissingPartError(
            "films as MP4 need PyAV, which is not installed: pip install 'plinko-sim[video]'",
            field="format",
        )
    import av  # noqa: PLC0415 - it may not be installed

    # `faststart` puts the index first, so that a browser plays before it has the whole file. For
    # that the library reads the file again; a file in memory would not do.
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
    context.thread_count = 1  # the bytes depend on the number of threads
    context.colorspace = context.color_primaries = context.color_trc = _BT709
    return stream


def _even(pixels: Pixels) -> Pixels:
    height, width = pixels.shape[:2]
    if height % 2 == width % 2 == 0:
        return np.ascontiguousarray(pixels)
    return np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
