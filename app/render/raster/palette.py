"""Make one palette for a picture or animation: frequent colours exactly, others by median cut.

Plates, gradients and bins cover nine tenths of a picture with about a hundred colours. The palette
contains them exactly, so that gradients have no bands and need no dithering. Its other entries
serve the edges.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from PIL import Image

from plinko.app.render.raster import pixels as compiled

Pixels = npt.NDArray[np.uint8]

EXACT: Final = 96  # colours that the palette contains exactly
MOST: Final = 255  # colours in all
UNCHANGED: Final = 255  # the index that means 'as in the previous frame' in an animation
_WEIGHT: Final = 8  # greatest weight of a colour, in pixels
_ALIKE: Final = 3  # low bits of a channel that are ignored when grouping colours
_ROUNDS: Final = 3  # of k-means after the median cut
_MEMORY: Final = 1 << 15  # size of the table of pixels' colours and their indices


class Palette:
    """At most MOST colours for some pictures, and the conversion of pixels to indices.

    For one thread at a time, because it caches the indices it has found.
    """

    def __init__(self, pictures: Sequence[Pixels]) -> None:
        keys, counts = _counted(pictures)
        order = np.argsort(-counts, kind="stable")
        frequent, rest = _channels(keys[order[:EXACT]]), order[EXACT:]
        cut = _cut(_channels(keys[rest]), counts[rest]) if len(rest) else frequent[:0]
        self.colours = _by_green(np.concatenate([frequent, cut]))
        self._keys, self._values = _memory()

    def index(self, pixels: Pixels) -> Pixels:
        """The index of the nearest colour to each pixel (h, w, 3), shape (h, w)."""
        out = np.empty(pixels.shape[:2], np.uint8)
        compiled.index_pixels(pixels, self.colours, self._keys, self._values, out)
        return out


def _by_green(colours: Pixels) -> Pixels:
    """Sort the colours by green, as `index_pixels` requires."""
    return colours[np.argsort(colours[:, 1], kind="stable")]


def _memory() -> tuple[npt.NDArray[np.int32], Pixels]:
    return np.full(_MEMORY, -1, np.int32), np.zeros(_MEMORY, np.uint8)


def _cut(colours: Pixels, counts: npt.NDArray[np.int64]) -> Pixels:
    """Represent these colours (n, 3) by MOST - EXACT colours: median cut, then k-means."""
    # A colour's weight is bounded: a ball has few pixels, but viewers look at it.
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
    """Replace groups of similar colours by their means, with the sums of their weights."""
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
    """Each pixel's colour as one number 0xRRGGBB, shape (n,)."""
    channels = np.zeros((*pixels.shape[:-1], 4), np.uint8)
    for channel in range(3):  # four times as fast as one assignment for all channels
        channels[..., channel] = pixels[..., 2 - channel]
    return channels.view("<u4").reshape(-1)


def _channels(keys: npt.NDArray[np.uint32]) -> Pixels:
    return np.stack([keys >> 16, keys >> 8 & 255, keys & 255], axis=-1).astype(np.uint8)


def _counted(
    pictures: Sequence[Pixels],
) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.int64]]:
    """All colours in ascending order, and the number of pixels of each."""
    found = np.concatenate([_keys(picture) for picture in pictures])
    keys, counts = np.unique(found, return_counts=True)
    return keys, counts
