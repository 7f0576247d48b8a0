"""Counts in which bins the drops of consecutive seeds land, from each aim."""

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, Final

import msgspec
import numpy as np

from plinko.engine.batches.block import block_of
from plinko.engine.batches.job import Job
from plinko.engine.batches.workers import Here, Workers
from plinko.engine.board.model import Board
from plinko.engine.errors import ParameterError
from plinko.engine.parameters import Exact
from plinko.engine.physics.array_types import Floats

STEPS: Final = 4
"""Number of aims that are counted to each side, if a player may aim anywhere in an interval."""


Count = Annotated[int, msgspec.Meta(ge=0, le=1 << 53)]
"""A number of drops, of which a share is still an exact quotient of float64."""


class Landings(msgspec.Struct, frozen=True, rename={"unsettled_count": "unsettled"}):
    """How many drops of the seeds `first`, `first` + 1, … landed in each bin, and how many in none.

    aim: the middle of the starts that seeds drew, m; None for the board's own.
    """

    aim: float | None
    histogram: tuple[Count, ...]
    unsettled_count: Count
    first: Count = 0

    @property
    def drops(self) -> int:
        """Number of drops."""
        return sum(self.histogram) + self.unsettled_count

    @property
    def next_seed(self) -> int:
        """The seed after the last one that was dropped."""
        return self.first + self.drops

    @property
    def chances(self) -> Floats:
        """The share of drops in each bin, shape (bins,); the rest up to 1 did not land."""
        return np.array(self.histogram, np.float64) / max(self.drops, 1)

    def to_dict(self) -> dict[str, Any]:
        """The JSON form."""
        return {
            "aim": self.aim,
            "first": self.first,
            "drops": self.drops,
            "histogram": list(self.histogram),
            "unsettled": self.unsettled_count,
        }


def aims_of(board: Board) -> tuple[float | None, ...]:
    """The aims that are counted: None for the board's own x, then all others that a player has.

    On a mirrored board, one side is enough. If a player may aim anywhere in an interval, STEPS
    evenly spaced aims on each side represent it: the return averages over the jitter, so it changes
    smoothly with the aim.
    """
    zone = board.drop
    if zone.slots:
        others = [slot for slot in zone.slots if abs(slot - zone.x) <= zone.aim_span]
    elif zone.aim_span > 0.0:
        part = zone.aim_span / STEPS
        others = [zone.x + k * part for k in range(-STEPS, STEPS + 1)]
    else:
        others = []
    if is_mirrored(board):
        others = [aim for aim in others if aim > zone.x]
    return (None, *(aim for aim in others if aim != zone.x))


def is_mirrored(board: Board) -> bool:
    """Whether a board is its own mirror image about x = 0, payouts not considered."""
    pegs = {(p.x, p.y, p.radius) for p in board.pegs}
    walls = {frozenset(((w.x1, w.y1), (w.x2, w.y2))) for w in board.walls}
    return (
        board.drop.x == 0.0
        and board.bins.edges == tuple(-edge for edge in reversed(board.bins.edges))
        and pegs == {(-x, y, radius) for x, y, radius in pegs}
        and walls == {frozenset((-x, y) for x, y in wall) for wall in walls}
    )


def more(
    board: Board,
    found: Landings,
    drops: int,
    workers: Workers | None = None,
    progress: Callable[[int], None] | None = None,
) -> Landings:
    """Return `found` plus the landings of the next `drops` seeds, computed by `workers`.

    workers: default is this process.
    progress: called now and then with the number of new drops done.
    """
    job = Job(board, Exact(), found.next_seed, drops, found.aim)
    histogram, unsettled, done = np.zeros(board.bins.count, np.int64), 0, 0
    for _, block in (workers or Here()).compute(partial(block_of, job), range(job.blocks)):
        histogram += np.array(block.histogram)
        unsettled += block.unsettled_count
        done += block.drops
        if progress is not None:
            progress(done)
    counted = Landings(found.aim, tuple(histogram.tolist()), unsettled, found.next_seed)
    return joined(found, counted)


def joined(found: Landings, following: Landings) -> Landings:
    """Add two landings from the same aim; the seeds of `following` must continue `found`'s."""
    if (found.aim, found.next_seed) != (following.aim, following.first):
        raise ParameterError(
            f"seeds from {following.first} at aim {following.aim} do not follow those before "
            f"{found.next_seed} at aim {found.aim}: seeds must be consecutive, and aims equal",
            field="first",
        )
    histogram = np.add(found.histogram, following.histogram).tolist()
    unsettled = found.unsettled_count + following.unsettled_count
    return Landings(found.aim, tuple(histogram), unsettled, found.first)


def none_yet(board: Board) -> tuple[Landings, ...]:
    """Empty landings for each aim."""
    empty = (0,) * board.bins.count
    return tuple(Landings(aim, empty, 0) for aim in aims_of(board))


def none_after(found: Landings) -> Landings:
    """Empty landings for the seeds after `found`."""
    return Landings(found.aim, (0,) * len(found.histogram), 0, found.next_seed)
