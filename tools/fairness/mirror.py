"""The physics favours no side: balls from x and -x must end as mirror images, bit for bit.

The board must be its own mirror image. Then neither physics nor rounding may favour a side.
"""

import numpy as np
import numpy.typing as npt

from plinko.engine import Board, DropBatch, drop_many


def check_mirror(board: Board, pairs: int) -> list[float]:
    """The starts in m, of the seeds 0 to pairs - 1, whose mirror images end differently."""
    here = drop_many(board, range(pairs))
    there = drop_many(board, range(pairs), xs=-here.x_start)
    same = (
        (_bits(here.x_end) == _bits(-there.x_end))
        & (_bits(here.duration) == _bits(there.duration))
        & (here.impact_count == there.impact_count)
        & (here.outcome == there.outcome)
        & (here.bin == _seen_in_the_mirror(there))
    )
    unlike: list[float] = here.x_start[~same].tolist()
    return unlike


def _bits(values: npt.NDArray[np.float64]) -> npt.NDArray[np.uint64]:
    """The bits of float64 values; adding 0.0 makes -0.0 equal to 0.0."""
    return (values + 0.0).view(np.uint64)


def _seen_in_the_mirror(drops: DropBatch) -> npt.NDArray[np.int32]:
    """The bins counted from the other side; -1 (the ball did not land) stays."""
    return np.where(drops.bin < 0, drops.bin, drops.board.bins.count - 1 - drops.bin)
