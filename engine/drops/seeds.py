"""Finds seeds whose balls land in a bin, by trying one after the other: nothing steers a ball."""

from collections.abc import Iterator
from typing import Final

from plinko.engine.board.model import Board
from plinko.engine.drops.batch import drop_many
from plinko.engine.errors import ParameterError, shorten
from plinko.engine.seeding import SEED_LIMIT, parse_seed

FIRST_BATCH: Final = 256
LARGEST_BATCH: Final = 65_536
"""Drops that are computed together: few at first, because most bins are hit soon."""

PATIENCE: Final = 10_000_000
"""Consecutive seeds that may land elsewhere before the search gives up."""


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

    The search begins after the seed `after` (default: with 0) and ends after `count` seeds, or
    without a count, with the last possible seed, 2^64 - 1. aim: the middle in m of the starts that
    seeds draw. The seeds are ordinary ones: `drop(board, seed)` computes the same path.

    Raises ParameterError for a bin that the board does not have, if none of `patience` seeds in a
    row lands in it, and if there are fewer than `count` seeds up to the last one; SeedError and
    BoardError as `drop_many` does.
    """
    board = Board.named(board)
    check_bin(board, bin)
    if count is not None and count < 1:
        raise ParameterError(f"count is {count}: it must be at least 1", field="count")
    if patience < 1:
        raise ParameterError(f"patience is {patience}: it must be at least 1", field="patience")
    first = 0 if after is None else parse_seed(after) + 1
    return _found(Search(board, bin, first, aim, threads), count, patience)


def check_bin(board: Board, number: object) -> None:
    """Raise ParameterError unless `number` is the number of a bin of the board."""
    last = board.bins.count - 1
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= last:
        raise ParameterError(
            f"bin is {shorten(number)}: the bins of {board.name!r} are 0 to {last}",
            field="bin",
        )


class Search:
    """A search for seeds that land in a bin; `next` is the next seed to try."""

    def __init__(
        self, board: Board, bin_: int, first: int, aim: float | None, threads: int | None
    ) -> None:
        self.board = board
        self.bin = bin_
        self.next = first
        self._aim = aim
        self._threads = threads

    def take(self, most: int) -> list[int]:
        """Try at most the next `most` seeds; return those that land in the bin."""
        seeds = range(self.next, min(self.next + most, SEED_LIMIT))
        batch = drop_many(self.board, seeds, aim=self._aim, threads=self._threads)
        self.next = seeds.stop
        return [int(seed) for seed in batch.seed[batch.bin == self.bin]]


def _found(search: Search, count: int | None, patience: int) -> Iterator[int]:
    size, given, since = FIRST_BATCH, 0, search.next
    first = search.next
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
                f"{search.next - 1} lands in it; use more patience, or another bin",
                field="bin",
            )
        size = min(2 * size, LARGEST_BATCH)
    if count is not None:
        raise ParameterError(
            f"bin {search.bin}: only {given} of {count} seeds from {first} on land in it, because "
            "seeds end at 2^64 - 1; begin after a smaller seed",
            field="after",
        )
