"""Finds seeds whose balls land in a bin, by trying one after the other: nothing steers a ball."""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

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
    first = 0 if after is None else parse_seed(after) + 1
    return _found(board, bin, first, count, {"aim": aim, "patience": patience, "threads": threads})


def check_bin(board: Board, number: object) -> None:
    """Raise ParameterError unless `number` is the number of a bin of the board."""
    last = board.bins.count - 1
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= last:
        raise ParameterError(
            f"bin is {shorten(number)}: the bins of {board.name!r} are 0 to {last}",
            field="bin",
        )


def _found(
    board: Board, number: int, first: int, count: int | None, how: dict[str, Any]
) -> Iterator[int]:
    given = 0
    for given, (seed, _) in enumerate(landings(board, {number}, first, **how), 1):
        yield seed
        if given == count:
            return
    if count is not None:
        raise ParameterError(
            f"bin {number}: only {given} of {count} seeds from {first} on land in it, because "
            "seeds end at 2^64 - 1; begin after a smaller seed",
            field="after",
        )


def landings(
    board: Board,
    bins: set[int],
    first: int,
    *,
    aim: float | None = None,
    patience: int = PATIENCE,
    threads: int | None = None,
) -> Iterator[tuple[int, int]]:
    """Yield the seeds from `first` on that land in `bins`, which may change, each with its bin.

    Raises ParameterError if none of `patience` seeds in a row lands there.
    """
    if patience < 1:
        raise ParameterError(f"patience is {patience}: it must be at least 1", field="patience")
    begin = since = first
    size = FIRST_BATCH
    while begin < SEED_LIMIT:
        seeds = range(begin, min(begin + size, since + patience, SEED_LIMIT))
        batch = drop_many(board, seeds, aim=aim, threads=threads)
        for row in np.flatnonzero(np.isin(batch.bin, [*bins])):
            seed, number = int(batch.seed[row]), int(batch.bin[row])
            if number in bins:
                since = seed + 1
                yield seed, number
        if seeds.stop - since >= patience:
            where = " or ".join(map(str, sorted(bins)))
            raise ParameterError(
                f"none of the {patience:,} seeds from {since} to {seeds.stop - 1} lands in bin "
                f"{where}: use more patience, or other bins",
                field="bin",
            )
        begin, size = seeds.stop, min(2 * size, LARGEST_BATCH)
