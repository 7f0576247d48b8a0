"""A draw with exact odds: weights for the bins of a board, and seeds whose balls land in each."""

from collections.abc import Sequence
from typing import Any, Final

from engine.board import values
from engine.board.model import Board
from engine.drops.batch import drop_many
from engine.drops.seeds import FIRST_BATCH, LARGEST_BATCH, PATIENCE
from engine.errors import ParameterError
from engine.seeding import SEED_LIMIT, parse_seed

MAX_WEIGHT: Final = (1 << 53) - 1
"""What JavaScript reads as the same whole number."""


def find_draw(
    board: Board | str,
    weights: Sequence[int],
    *,
    per_bin: int = 1,
    after: int | str | None = None,
    patience: int = PATIENCE,
    threads: int | None = None,
) -> dict[str, Any]:
    """Return `{"weights": [...], "seeds": [[...], ...]}`: a draw as `POST rooms` takes it.

    weights: one for each bin from the left, whole numbers from 0 on; a ball lands in a bin with the
    chance of its weight among their sum. For each bin with a weight it has `per_bin` seeds, as
    texts: the first ones after the seed `after` (default: from 0 on) whose balls land there.

    Raises ParameterError for weights that are none, and when none of `patience` seeds in a row
    lands in a bin that lacks some; SeedError and BoardError as `drop_many` does.
    """
    board = Board.named(board)
    weighed = check_weights(board, weights)
    if per_bin < 1:
        raise ParameterError(f"per_bin is {per_bin}: it must be from 1 on", field="per_bin")
    if patience < 1:
        raise ParameterError(f"patience is {patience}: it must be from 1 on", field="patience")
    found: list[list[str]] = [[] for _ in weighed]
    lacking = {bin_ for bin_, weight in enumerate(weighed) if weight}
    begin = 0 if after is None else parse_seed(after) + 1
    size, since = FIRST_BATCH, begin
    while lacking:
        seeds = range(begin, min(begin + size, since + patience, SEED_LIMIT))
        if not seeds:
            raise ParameterError(
                f"no seed from {since} to {begin - 1} lands in any of the bins "
                f"{', '.join(map(str, sorted(lacking)))}, which have weights",
                field="weights",
            )
        batch = drop_many(board, seeds, threads=threads)
        for seed, bin_ in zip(batch.seeds.tolist(), batch.bin.tolist(), strict=True):
            if bin_ in lacking:
                found[bin_].append(str(seed))
                since = seed + 1
                if len(found[bin_]) == per_bin:
                    lacking.remove(bin_)
        begin, size = seeds.stop, min(2 * size, LARGEST_BATCH)
    return {"weights": list(weighed), "seeds": found}


def check_weights(board: Board, weights: object) -> tuple[int, ...]:
    """The weights of the board's bins; raises ParameterError that names what is wrong."""
    count = board.bins.count
    if not isinstance(weights, Sequence) or isinstance(weights, str) or len(weights) != count:
        raise ParameterError(
            f"weights is {values.shown(weights)}: the board {board.name!r} needs a list of "
            f"{count}, one for each of its bins",
            field="weights",
        )
    for bin_, weight in enumerate(weights):
        whole = isinstance(weight, int) and not isinstance(weight, bool)
        if not whole or not 0 <= weight <= MAX_WEIGHT:
            raise ParameterError(
                f"weights[{bin_}] is {values.shown(weight)}: it must be a whole number from 0 to "
                "2^53 - 1",
                field=f"weights[{bin_}]",
            )
    if not any(weights):
        raise ParameterError(
            "weights are all 0: at least one bin must have a weight", field="weights"
        )
    return tuple(weights)
