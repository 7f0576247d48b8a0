"""Solves a board's payout table: drops balls until its return is known, aim by aim.

Some seeds choose the table, and those after them judge it: by the drops that chose it a table
returns what it should, whatever it truly returns.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from typing import Any, Final

import numpy as np

from engine.batches.workers import Here, Workers
from engine.board.model import Board
from engine.board.payouts import Risk
from engine.errors import ParameterError
from engine.parameters import number
from engine.payouts import reference, table
from engine.payouts.landings import Landings, is_mirrored, more, none_after, none_yet
from engine.payouts.odds import DEVIATIONS, Odds, odds_of

PRECISE: Final = 1e-3
"""Half the interval of 95 % that the return from the board's own start is to be known to."""

PRECISE_AIM: Final = 2e-3
"""And that from any other aim: it has farther to its bounds."""

FEWEST: Final = 100_000
"""Drops from each aim before a table is solved at all."""

MOST: Final = 1_000_000_000
"""Drops from each aim after which the interval is what it is. For a top award of 1,000 times at one
in 15,000 some 300 million are needed."""

FEWEST_HITS: Final = 100
"""Balls that must have landed in a bin before its multiplier is reported without a warning: a
chance is then known to 20 % (95 % interval). A bin that was hit once or never may be ten times
likelier than it seems, and a multiplier solved from that is a guess."""

Block = tuple[Landings, ...]
"""Of each aim, the board's own start first."""

Pays = tuple[float, ...]
"""Multipliers of all bins, left to right."""

Progress = Callable[[int, int], None]
"""Called with the drops done and the drops that are needed as far as is known."""


@dataclass(frozen=True, slots=True)
class Payouts:
    """A solved table: the board with it, what was asked for, and the odds from each aim.

    odds: the board's own start first. landings: what they were computed from. chosen: the landings
    that the multipliers were solved for; none of their drops is among `landings`.
    """

    board: Board
    risk: Risk
    target: float
    odds: tuple[Odds, ...]
    landings: tuple[Landings, ...]
    chosen: tuple[Landings, ...]

    @property
    def chosen_by(self) -> int:
        """Drops that the multipliers were solved for, all aims together."""
        return sum(each.drops for each in self.chosen)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the table cannot be trusted for, a sentence each; empty where all is well."""
        rare = _rare_bins(self.chosen[0], self.board)
        return (*rare, *_not_monotone(self.multipliers))

    @property
    def multipliers(self) -> tuple[float, ...]:
        """Of all bins, left to right."""
        return self.board.bins.multipliers

    @property
    def drops(self) -> int:
        """How many judge it, all aims together."""
        return sum(each.drops for each in self.landings)

    @property
    def least(self) -> Odds:
        """The aim that returns least."""
        return min(self.odds, key=lambda each: each.returned)

    def to_dict(self) -> dict[str, Any]:
        """The JSON form: multipliers, and odds of each aim."""
        return {
            "board": self.board.name,
            "board_digest": self.board.digest,
            "risk": self.risk,
            "target": self.target,
            "multipliers": list(self.multipliers),
            "drops": self.drops,
            "chosen_by": self.chosen_by,
            "least": {"aim": self.least.aim, "return": self.least.returned},
            "aims": [each.to_dict() for each in self.odds],
            "warnings": list(self.warnings),
        }


def _rare_bins(chosen: Landings, board: Board) -> tuple[str, ...]:
    """A warning if some bins were hit too rarely to say what they should pay."""
    hits = np.array(chosen.histogram)
    if is_mirrored(board):
        hits = hits + hits[::-1]
    rare = np.flatnonzero(hits < FEWEST_HITS)
    if not len(rare):
        return ()
    fewest = int(hits[rare].min())
    bins = ", ".join(map(str, rare))
    wanted = ceil(chosen.drops * FEWEST_HITS / max(fewest, 1))
    more = f"about {wanted:,}" if fewest else f"far more than {wanted:,}"
    return (
        f"{chosen.drops:,} drops cannot tell how often bins {bins} are hit (the rarest: "
        f"{fewest} hits, {FEWEST_HITS} are needed): what these pay is a guess; it takes {more} "
        "drops",
    )


def _not_monotone(multipliers: Pays) -> tuple[str, ...]:
    """A warning if multipliers fall anywhere from the middle to the sides."""
    middle = len(multipliers) // 2
    right = [(k, k + 1) for k in range(middle, len(multipliers) - 1)]
    left = [(k, k - 1) for k in range((len(multipliers) - 1) // 2, 0, -1)]
    for inner, outer in (*left, *right):
        if multipliers[outer] < multipliers[inner]:
            return (
                "the table is not monotone: multipliers fall from the middle to the sides, where "
                f"bin {outer} pays {multipliers[outer]:g} beside {multipliers[inner]:g} in bin "
                f"{inner}",
            )
    return ()


def solve_payouts(
    board: Board | str,
    *,
    returned: float = 0.99,
    risk: str = "medium",
    drops: int = MOST,
    threads: int | None = None,
    workers: Workers | None = None,
    progress: Progress | None = None,
) -> Payouts:
    """Solve the payout table of `board`, a board or a preset's name, for a return such as 0.99.

    Drops balls with the seeds 0, 1, 2 … from the board's own start and from every aim that a player
    has, until the own start's return is known to PRECISE, or for at most `drops` from each aim;
    then as many with later seeds, which say what the table returns. `threads` as for `drop_many`;
    `workers` compute elsewhere (`engine.batches.workers`). `progress` is called now and then.
    Raises ParameterError for a return or risk there is none of, or where no table is within its
    bounds.
    """
    target = number(returned, "return", 0.5, 1.0)
    chosen = risk_of(risk)
    if drops < 1:
        raise ParameterError(f"drops {drops!r} is not at least 1", field="drops")
    found = Board.named(board)

    def count(begun: Block, pays_of: Callable[[Block], Pays], told: Progress) -> Block:
        return _until_known(begun, pays_of, drops, Counting(found, workers or Here(threads), told))

    def told(done: int, of: int) -> None:
        if progress is not None:
            progress(done, 2 * of)  # as many judge

    def solved(landings: Block) -> Pays:
        return table_for(found, landings, target, chosen)

    choosing = count(none_yet(found), solved, told)
    pays = solved(choosing)
    first = sum(each.drops for each in choosing)

    def told_again(done: int, of: int) -> None:
        if progress is not None:
            progress(first + done, first + of)

    judging = count(tuple(map(none_after, choosing)), lambda _: pays, told_again)
    paying = replace(found, bins=replace(found.bins, multipliers=pays))
    odds = tuple(odds_of(each, pays) for each in judging)
    return Payouts(paying, chosen, target, odds, judging, choosing)


def risk_of(risk: object) -> Risk:
    """`risk` if it is one; ParameterError naming it if not."""
    for known in reference.HALF_TABLES:
        if risk == known:
            return known
    raise ParameterError(f"risk {risk!r} is none of low, medium, high", field="risk")


def table_for(board: Board, landings: Block, target: float, risk: Risk) -> Pays:
    """Multipliers for landings that are there; ParameterError where none are within the bounds."""
    chances = np.array([each.chances for each in landings])
    return table.solve(chances, risk, table.bounds_of(target), is_mirrored(board))


def needed(odds: Odds, own: bool) -> int:
    """Drops after which the return is known as it should be, by what its volatility is so far."""
    return ceil((DEVIATIONS * odds.volatility / (PRECISE if own else PRECISE_AIM)) ** 2)


@dataclass(frozen=True, slots=True)
class Counting:
    """How drops are counted: on which board, by whom, and who is told."""

    board: Board
    workers: Workers
    progress: Progress


def _until_known(
    begun: Block, pays_of: Callable[[Block], Pays], drops: int, counting: Counting
) -> Block:
    """More landings, from each aim at most `drops`, until what the table returns is known.

    pays_of: the table, by what landed.
    """
    landings = begun
    wanted = [min(FEWEST, drops)] * len(landings)
    while any(each.drops < need for each, need in zip(landings, wanted, strict=True)):
        landings = _count(landings, wanted, counting)
        pays = pays_of(landings)
        known = [needed(odds_of(each, pays), own=k == 0) for k, each in enumerate(landings)]
        wanted = [min(drops, need) for need in known]
    return landings


def _count(landings: Block, wanted: list[int], counting: Counting) -> Block:
    """The landings of at least so many drops from each aim."""
    counted = list(landings)
    for k, need in enumerate(wanted):
        if counted[k].drops < need:
            before = sum(each.drops for each in counted)
            left = sum(max(n - each.drops, 0) for n, each in zip(wanted, counted, strict=True))
            told = partial(_told, counting.progress, before, before + left)
            some = need - counted[k].drops
            counted[k] = more(counting.board, counted[k], some, counting.workers, told)
    return tuple(counted)


def _told(progress: Progress, before: int, of: int, done: int) -> None:
    progress(before + done, of)
