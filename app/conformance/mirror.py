"""Test that physics favours no side: balls from x and -x must end as mirror images, bit for bit.

The board must be its own mirror image. Then neither physics nor rounding may favour a side.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plinko.app.errors import InvalidValueError
from plinko.engine import Board, DropBatch, drop_many
from plinko.engine.payouts.landings import is_mirrored


@dataclass(frozen=True, slots=True)
class Mirror:
    """The number of pairs of drops compared, and the starts in m of those that differ."""

    pairs: int
    unlike: tuple[float, ...]

    def to_dict(self) -> dict[str, object]:
        return {"pairs": self.pairs, "unlike": list(self.unlike)}


def check_mirror(board: Board, pairs: int) -> Mirror:
    """Compare drops of the seeds 0 to pairs - 1 with drops from the mirrored starts.

    Raises InvalidValueError if the board is not its own mirror image about x = 0.
    """
    if not is_mirrored(board):
        raise InvalidValueError(
            f"board {board.name!r} is not its own mirror image about x = 0", field="board"
        )
    seeds = range(pairs)
    here = drop_many(board, seeds)
    there = drop_many(board, seeds, xs=-here.x_start)
    same = (
        (_bits(here.x_end) == _bits(-there.x_end))
        & (_bits(here.duration) == _bits(there.duration))
        & (here.impact_count == there.impact_count)
        & (here.outcome == there.outcome)
        & (here.bin == _seen_in_the_mirror(there))
    )
    return Mirror(pairs, tuple(here.x_start[~same].tolist()))


def _bits(values: npt.NDArray[np.float64]) -> npt.NDArray[np.uint64]:
    """The bits of float64 values; adding 0.0 makes -0.0 equal to 0.0."""
    return (values + 0.0).view(np.uint64)


def _seen_in_the_mirror(drops: DropBatch) -> npt.NDArray[np.int32]:
    """The bins counted from the other side; -1 (the ball did not land) stays."""
    return np.where(drops.bin < 0, drops.bin, drops.board.bins.count - 1 - drops.bin)
