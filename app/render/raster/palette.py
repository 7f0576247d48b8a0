"""One palette for a whole picture or animation: frequent colours exactly, the rest by median cut.

Nine tenths of a picture are plates, gradients and bins in some hundred colours. They are kept as
they are, so that gradients have no bands and need no dithering; what is left serves the edges.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from app.render.raster import pixels as compiled

Pixels = npt.NDArray[np.uint8]

EXACT: Final = 96  # colours kept as they are
MOST: Final = 255  # colours in all; the last index says 'unchanged' in an animation
UNCHANGED: Final = 255
_WEIGHT: Final = 8  # pixels of a colour, beyond which it counts no more
_ALIKE: Final = 3  # bits of a channel in which colours that count as one differ
_ROUNDS: Final = 3  # of moving colours to the mean of what they stand for
_MEMORY: Final = 1 << 15  # colours remembered


class Palette:
    """The colours of some pictures, at most MOST, and the way from pixels to indices.

    For one thread at a time: it remembers the indices it has found.
    """

    def __init__(self, pictures: Sequence[Pixels]) -> None:
        keys, counts = _counted(pictures)
        order = np.argsort(-counts, kind="stable")
        frequent, rest = _channels(keys[order[:EXACT]]), order[EXACT:]
        cut = _cut(_channels(keys[rest]), counts[rest]) if len(rest) else frequent[:0]
        self.colours = _by_green(np.concatenate([frequent, cut]))
        self._keys, self._values = _memory()

    def index(self, pixels: Pixels) -> Pixels:
        """Index of the nearest colour to each pixel of (h, w, 3), shape (h, w)."""
        out = np.empty(pixels.shape[:2], np.uint8)
        compiled.index_pixels(pixels, self.colours, self._keys, self._values, out)
        return out


def _by_green(colours: Pixels) -> Pixels:
    """In the order in which `index_pixels` takes them."""
    return colours[np.argsort(colours[:, 1], kind="stable")]


def _memory() -> tuple[npt.NDArray[np.int32], Pixels]:
    return np.full(_MEMORY, -1, np.int32), np.zeros(_MEMORY, np.uint8)


def _cut(colours: Pixels, counts: npt.NDArray[np.int64]) -> Pixels:
    """The MOST - EXACT colours that stand for these (n, 3): median cut, then means of clusters."""
    # How often a colour occurs counts up to a point: a ball is small, and looked at.
    colours, weights = _grouped(colours, np.minimum(counts, _WEIGHT))
    line = Image.fromarray(np.repeat(colours, np.minimum(weights, _WEIGHT), axis=0)[None])
    quantized = line.quantize(MOST - EXACT, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    found = np.array(quantized.getpalette(), np.uint8).reshape(-1, 3)[: MOST - EXACT]
    for _ in range(_ROUNDS):
        found = _by_green(found)
        nearest = np.empty((1, len(colours)), np.uint8)
        compiled.index_pixels(colours[None], found, *_memory(), nearest)
        means, total = _means(nearest[0], colours, weights, len(found))
        found = np.where(total[:, None] > 0.0, means, found)
    return found


def _grouped(
    colours: Pixels, weights: npt.NDArray[np.int64]
) -> tuple[Pixels, npt.NDArray[np.int64]]:
    """Means of colours that hardly differ, and their weights together: far fewer."""
    _, group = np.unique(_keys(colours >> np.uint8(_ALIKE)), return_inverse=True)
    means, total = _means(group, colours, weights, int(group.max()) + 1)
    return means, total.astype(np.int64)


def _means(
    group: npt.NDArray[Any], colours: Pixels, weights: npt.NDArray[np.int64], count: int
) -> tuple[Pixels, npt.NDArray[Any]]:
    """The mean colour of each group, shape (count, 3), and its weight, shape (count,)."""
    total = np.bincount(group, weights.astype(np.float64), minlength=count)
    sums = [np.bincount(group, weights * colours[:, i], minlength=count) for i in range(3)]
    return np.rint(np.stack(sums, -1) / np.maximum(total, 1.0)[:, None]).astype(np.uint8), total


def _keys(pixels: Pixels) -> npt.NDArray[np.uint32]:
    """One number for each colour, shape (n,)."""
    channels = np.zeros((*pixels.shape[:-1], 4), np.uint8)
    for channel in range(3):  # one by one takes a quarter of the time
        channels[..., channel] = pixels[..., 2 - channel]
    return channels.view("<u4").reshape(-1)


def _channels(keys: npt.NDArray[np.uint32]) -> Pixels:
    return np.stack([keys >> 16, keys >> 8 & 255, keys & 255], axis=-1).astype(np.uint8)


def _counted(
    pictures: Sequence[Pixels],
) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.int64]]:
    """All colours, ascending, and how many pixels have each."""
    found = np.concatenate([_keys(picture) for picture in pictures])
    keys, counts = np.unique(found, return_counts=True)
    return keys, counts
