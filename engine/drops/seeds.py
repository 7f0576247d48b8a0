"""Which seeds end in a bin: found by dropping one after the other, since nothing steers a ball."""

from collections.abc import Iterator
from typing import Final

from engine.board import values
from engine.board.model import Board
from engine.drops.batch import drop_many
from engine.errors import ParameterError
from engine.seeding import SEED_LIMIT, parse_seed

FIRST_BATCH: Final = 256
LARGEST_BATCH: Final = 65_536
"""Drops that are computed together: few at first, since most bins are hit soon."""

PATIENCE: Final = 10_000_000
"""Seeds in a row that may land elsewhere before the search ends with an error."""


def seeds_landing_in(
    board: Board | str,
    bin: int,  # noqa: A002 - the word that every drop has for it
    *,
    after: int | str | None = None,
    count: int | None = None,
    aim: float | None = None,
    patience: int = PATIENCE,
    threads: int | None = None,
) -> Iterator[int]:
    """Yield all seeds whose balls land in `bin`, in ascending order.

    The first is the next after the seed `after` (default: from 0 on). It ends after `count` seeds;
    without a count, only with the last seed there is. `aim` is the middle of the starts that seeds
    draw, m. A ball of such a seed is one that would have fallen so anyway: `drop(board, seed)`.

    Raises ParameterError for a bin that the board does not have, and when none of `patience` seeds
    in a row lands in it; SeedError and BoardError as `drop_many` does.
    """
    board = Board.named(board)
    check_bin(board, bin)
    if count is not None and count < 1:
        raise ParameterError(f"count is {count}: it must be from 1 on", field="count")
    if patience < 1:
        raise ParameterError(f"patience is {patience}: it must be from 1 on", field="patience")
    first = 0 if after is None else parse_seed(after) + 1
    return _found(Search(board, bin, first, aim, threads), count, patience)


def check_bin(board: Board, number: object) -> None:
    """Raise ParameterError for what is no bin of the board."""
    last = board.bins.count - 1
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= last:
        raise ParameterError(
            f"bin is {values.shown(number)}: the bins of {board.name!r} are 0 to {last}",
            field="bin",
        )


class Search:
    """A search for seeds that land in a bin, from `next` on."""

    def __init__(
        self, board: Board, bin_: int, first: int, aim: float | None, threads: int | None
    ) -> None:
        self.board = board
        self.bin = bin_
        self.next = first
        self._aim = aim
        self._threads = threads

    def take(self, most: int) -> list[int]:
        """Drop at most so many of the next seeds; those that land in the bin."""
        seeds = range(self.next, min(self.next + most, SEED_LIMIT))
        batch = drop_many(self.board, seeds, aim=self._aim, threads=self._threads)
        self.next = seeds.stop
        return [int(seed) for seed in batch.seeds[batch.bin == self.bin]]


def _found(search: Search, count: int | None, patience: int) -> Iterator[int]:
    size, given, since = FIRST_BATCH, 0, search.next
    while search.next < SEED_LIMIT:
        for seed in search.take(min(size, since + patience - search.next)):
            yield seed
            given += 1
            since = seed + 1
            if given == count:
                return
        if search.next - since >= patience:
            raise ParameterError(
                f"bin {search.bin}: none of the {patience:,} seeds from {since} to "
                f"{search.next - 1} lands in it",
                field="bin",
            )
        size = min(2 * size, LARGEST_BATCH)
