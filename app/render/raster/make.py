"""Write pixels.wasm, the machine code of pixels.py: python -m plinko.app.render.raster.make"""

from pathlib import Path
from typing import Final

import numpy as np

from plinko.app.render.raster import pixels
from plinko.engine.artifact.make import made_by

KERNELS: Final = Path(pixels.__file__)
ARTIFACT: Final = KERNELS.with_suffix(".wasm")


def sample_calls() -> None:
    """Call each kernel that Python calls once, so that it is compiled."""
    picture, colours = np.zeros((2, 2, 3), np.uint8), np.zeros((1, 3), np.uint8)
    colour, gloss = np.zeros(3), np.zeros((2, 2, 4))
    paint = pixels.BallPaint(colour, colour, 0.5, colour, 0.1, 0.1, 0.5, gloss)
    pixels.paint_balls(picture, np.array([[1.0, 1.0, 1.0, 0.0, 1.0]]), 2, paint)
    pixels.paint_trail(picture, np.array([[0.0, 0.0], [1.0, 1.0]]), 1.0, 2, colour, 0.5)
    line = np.array([[0.0, 0.0], [1.0, 1.0]])
    pixels.paint_line(picture, line, np.ones((1, 1)), np.ones((1, 5)))
    pixels.paint_strokes(picture, np.array([[0.0, 0.0, 1.0, 1.0, 1.0, 0.5]]), np.zeros((1, 3)))
    indices, keys = np.zeros((2, 2), np.uint8), np.full(4, -1, np.int32)
    pixels.index_pixels(picture, colours, keys, np.zeros(4, np.uint8), indices)


def made() -> bytes:
    return made_by(
        "from plinko.app.render.raster.make import KERNELS, sample_calls; "
        "from plinko.engine.artifact.record_types import compiled_beside; "
        "made = compiled_beside(KERNELS, sample_calls)"
    )


if __name__ == "__main__":
    ARTIFACT.write_bytes(made())
