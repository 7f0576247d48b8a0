"""Makes a draw with exact odds: weights for a board's bins, and seeds that land in each bin."""

from collections.abc import Sequence
from typing import Any, Final

from plinko.engine.board.model import Board
from plinko.engine.drops.seeds import PATIENCE, landings
from plinko.engine.errors import ParameterError, shorten
from plinko.engine.seeding import parse_seed

MAX_WEIGHT: Final = (1 << 53) - 1
"""Largest integer that JavaScript represents exactly."""


def find_draw(
    board: Board | str,
    weights: Sequence[int],
    *,
    per_bin: int = 1,
    after: int | str | None = None,
    patience: int = PATIENCE,
    threads: int | None = None,
) -> dict[str, Any]:
    """Return `{"weights": [...], "seeds": [[...], ...]}`, a draw as `POST rooms` accepts it.

    weights: one whole number >= 0 for each bin, from the left. The chance of a bin is its weight
    divided by their sum. Each bin with a positive weight gets `per_bin` seeds, as strings: the
    first seeds after `after` (default: from 0 on) whose balls land there.

    Raises ParameterError for invalid weights, and if `patience` seeds in a row add nothing to an
    unfinished bin; SeedError and BoardError as `drop_many` does.
    """
    board = Board.named(board)
    weighed = check_weights(board, weights)
    if per_bin < 1:
        raise ParameterError(f"per_bin is {per_bin}: it must be at least 1", field="per_bin")
    found: list[list[str]] = [[] for _ in weighed]
    lacking = {bin_ for bin_, weight in enumerate(weighed) if weight}
    begin = 0 if after is None else parse_seed(after) + 1
    for seed, bin_ in landings(board, lacking, begin, patience=patience, threads=threads):
        found[bin_].append(str(seed))
        if len(found[bin_]) == per_bin:
            lacking.remove(bin_)
            if not lacking:
                return {"weights": list(weighed), "seeds": found}
    raise ParameterError(
        f"no further seed up to the last one, 2^64 - 1, lands in bin "
        f"{' or '.join(map(str, sorted(lacking)))}: begin after a smaller seed",
        field="after",
    )


def check_weights(board: Board, weights: object) -> tuple[int, ...]:
    """Return `weights` as a tuple; ParameterError unless they are valid for the board's bins."""
    count = board.bins.count
    if not isinstance(weights, Sequence) or isinstance(weights, str) or len(weights) != count:
        raise ParameterError(
            f"weights is {shorten(weights)}: the board {board.name!r} needs a list of "
            f"{count}, one for each of its bins",
            field="weights",
        )
    for bin_, weight in enumerate(weights):
        whole = isinstance(weight, int) and not isinstance(weight, bool)
        if not whole or not 0 <= weight <= MAX_WEIGHT:
            raise ParameterError(
                f"weights[{bin_}] is {shorten(weight)}: it must be a whole number from 0 to "
                "2^53 - 1",
                field=f"weights[{bin_}]",
            )
    if not any(weights):
        raise ParameterError(
            "weights are all 0: at least one bin must have a weight", field="weights"
        )
    return tuple(weights)
