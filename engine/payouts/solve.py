"""Solves a board's payout table: drops balls until its return is known, aim by aim."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil
from typing import Any, Final

import numpy as np

from engine.board.model import Board
from engine.errors import ParameterError
from engine.parameters import number
from engine.payouts import reference, table
from engine.payouts.landings import AT_ONCE, Landings, is_mirrored, more, none_yet
from engine.payouts.odds import DEVIATIONS, Odds, odds_of
from engine.payouts.reference import Risk

PRECISE: Final = 1e-3
"""Half the interval of 95 % that the return from the board's own start is to be known to."""

PRECISE_AIM: Final = 2e-3
"""And that from any other aim: it has farther to its bounds."""

FEWEST: Final = 100_000
"""Drops from each aim before a table is solved at all."""

MOST: Final = 200_000_000
"""Drops from each aim after which the interval is what it is."""

Progress = Callable[[int, int], None]
"""Called with the drops done and the drops that are needed as far as is known."""


@dataclass(frozen=True, slots=True)
class Payouts:
    """A solved table: the board with it, what was asked for, and the odds from each aim.

    odds: the board's own start first. landings: what they were computed from.
    """

    board: Board
    risk: Risk
    target: float
    odds: tuple[Odds, ...]
    landings: tuple[Landings, ...]

    @property
    def multipliers(self) -> tuple[float, ...]:
        """Of all bins, left to right."""
        return self.board.bins.multipliers

    @property
    def drops(self) -> int:
        """How many it took, all aims together."""
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
            "least": {"aim": self.least.aim, "return": self.least.returned},
            "aims": [each.to_dict() for each in self.odds],
        }


def solve_payouts(
    board: Board | str,
    *,
    returned: float = 0.99,
    risk: str = "medium",
    drops: int = MOST,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Payouts:
    """Solve the payout table of `board`, a board or a preset's name, for a return such as 0.99.

    Drops balls with the seeds 0, 1, 2 … from the board's own start and from every aim that a player
    has, until the own start's return is known to PRECISE, or for at most `drops` from each aim.
    `threads` as for `drop_many`; `progress` is called now and then. Raises ParameterError for a
    return or risk there is none of, or where no table is within its bounds.
    """
    target = number(returned, "return", 0.5, 1.0)
    chosen = risk_of(risk)
    if drops < 1:
        raise ParameterError(f"drops {drops!r} is not at least 1", field="drops")
    found = Board.named(board)
    landings = none_yet(found)
    wanted = [min(FEWEST, drops)] * len(landings)
    while True:
        landings = _count(found, landings, wanted, threads, progress)
        solved = solve_for(found, landings, target, chosen)
        wanted = [min(drops, _needed(odds, own=k == 0)) for k, odds in enumerate(solved.odds)]
        if all(each.drops >= need for each, need in zip(landings, wanted, strict=True)):
            return solved


def risk_of(risk: object) -> Risk:
    """`risk` if it is one; ParameterError naming it if not."""
    for known in reference.HALF_TABLES:
        if risk == known:
            return known
    raise ParameterError(f"risk {risk!r} is none of low, medium, high", field="risk")


def solve_for(board: Board, landings: tuple[Landings, ...], target: float, risk: Risk) -> Payouts:
    """The table for landings that are there; ParameterError where none is within its bounds."""
    chances = np.array([each.chances for each in landings])
    pays = table.solve(chances, risk, table.bounds_of(target), is_mirrored(board))
    paying = replace(board, bins=replace(board.bins, multipliers=pays))
    odds = tuple(odds_of(each, pays) for each in landings)
    return Payouts(paying, risk, target, odds, landings)


def _needed(odds: Odds, own: bool) -> int:
    """Drops after which the return is known as it should be, by what its volatility is so far."""
    return ceil((DEVIATIONS * odds.volatility / (PRECISE if own else PRECISE_AIM)) ** 2)


def _count(
    board: Board,
    landings: tuple[Landings, ...],
    wanted: list[int],
    threads: int | None,
    progress: Progress | None,
) -> tuple[Landings, ...]:
    """The landings of at least so many drops from each aim."""
    counted = list(landings)
    for k, need in enumerate(wanted):
        while counted[k].drops < need:
            some = min(AT_ONCE, need - counted[k].drops)
            counted[k] = more(board, counted[k], some, threads)
            if progress is not None:
                done = sum(each.drops for each in counted)
                left = sum(max(n - each.drops, 0) for n, each in zip(wanted, counted, strict=True))
                progress(done, done + left)
    return tuple(counted)
