"""Solves a board's payout table: drops balls from each aim until its return is known.

The first seeds choose the table, and as many later ones judge it, because a table fitted to a
sample has the wanted return on that sample, even if its true return differs.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from typing import Any, Final

import numpy as np

from plinko.engine.batches.workers import Here, Workers
from plinko.engine.board.model import Board
from plinko.engine.board.payouts import RISKS, Risk
from plinko.engine.errors import ParameterError
from plinko.engine.parameters import number
from plinko.engine.payouts import table
from plinko.engine.payouts.landings import Landings, is_mirrored, more, none_after, none_yet
from plinko.engine.payouts.odds import DEVIATIONS, Odds, odds_of
from plinko.engine.physics.array_types import Ints

PRECISE: Final = 1e-3
"""Wanted half-width of the 95 % interval of the return from the board's own start."""

PRECISE_AIM: Final = 2e-3
"""The same for any other aim, whose bounds are wider."""

PRECISE_WORLD: Final = 4e-3
"""The same for the presets of worlds: there are many, and each can be counted on."""

FEWEST: Final = 100_000
"""Drops from each aim before a table is solved for the first time."""

MOST: Final = 1_000_000_000
"""Most drops from each aim, however wide the interval is then. A top award of 1,000 times with a
chance of 1 in 15,000 needs about 300 million."""

FEWEST_HITS: Final = 100
"""Balls in a bin without which its multiplier gets a warning. With 100, its chance is known to 20 %
(95 % interval). A bin with one or no hit may be ten times likelier than it seems, and its
multiplier would be a guess."""

Block = tuple[Landings, ...]
"""Landings from each aim, the board's own start first."""

Pays = tuple[float, ...]
"""Multipliers of all bins, left to right."""

Progress = Callable[[int, int], None]
"""Called with the drops done and the current estimate of the drops needed."""


@dataclass(frozen=True, slots=True)
class Payouts:
    """A solved table: the board with it, the wanted return, and the odds from each aim.

    odds: the board's own start first. landings: the drops from which the odds were computed.
    chosen: the drops for which the multipliers were solved; they are not in `landings`.
    """

    board: Board
    risk: Risk
    target: float
    odds: tuple[Odds, ...]
    landings: tuple[Landings, ...]
    chosen: tuple[Landings, ...]

    @property
    def chosen_by(self) -> int:
        """Drops for which the multipliers were solved, over all aims."""
        return sum(each.drops for each in self.chosen)

    @property
    def rare_bins(self) -> tuple[int, ...]:
        """Bins that too few drops hit to solve their multipliers."""
        return tuple(np.flatnonzero(self._hits < FEWEST_HITS).tolist())

    @property
    def falling_bins(self) -> tuple[int, ...]:
        """Bins that pay less than their neighbour nearer the middle."""
        pays = self.multipliers
        left = [k for k in range((len(pays) - 1) // 2) if pays[k] < pays[k + 1]]
        right = [k for k in range(len(pays) // 2 + 1, len(pays)) if pays[k] < pays[k - 1]]
        return (*left, *right)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to trust the table, a sentence each."""
        found = []
        if self.rare_bins:
            drops, fewest = self.chosen[0].drops, int(self._hits.min())
            wanted = ceil(drops * FEWEST_HITS / max(fewest, 1))
            more = f"about {wanted:,}" if fewest else f"far more than {wanted:,}"
            found.append(
                f"{drops:,} balls are too few to know how often bins "
                f"{', '.join(map(str, self.rare_bins))} are hit (the rarest: {fewest} hits, "
                f"{FEWEST_HITS} are needed): their multipliers are a guess; use {more}"
            )
        if self.falling_bins:
            found.append(
                "multipliers should rise from the middle to the sides, but bins "
                f"{', '.join(map(str, self.falling_bins))} pay less than their neighbours nearer "
                "the middle"
            )
        return tuple(found)

    @property
    def _hits(self) -> Ints:
        """How many of the fitting drops hit each bin, or its mirror image."""
        hits = np.array(self.chosen[0].histogram)
        return hits + hits[::-1] if is_mirrored(self.board) else hits

    @property
    def multipliers(self) -> tuple[float, ...]:
        """Multipliers of all bins, left to right."""
        return self.board.bins.multipliers

    @property
    def drops(self) -> int:
        """Drops that judge the table, over all aims."""
        return sum(each.drops for each in self.landings)

    @property
    def least(self) -> Odds:
        """The odds from the aim with the lowest return."""
        return min(self.odds, key=lambda each: each.returned)

    def to_dict(self) -> dict[str, Any]:
        """The JSON form."""
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
            "rare_bins": list(self.rare_bins),
            "falling_bins": list(self.falling_bins),
        }


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
    has, until the returns are known precisely enough, or `drops` balls from each aim. Then as many
    balls with later seeds measure the table's return.

    threads: as for `drop_many`. workers: compute elsewhere (`plinko.engine.batches.workers`).
    progress: called now and then.

    Raises ParameterError for an invalid return or risk, and if no table is within the bounds.
    """
    target = number(returned, "return", 0.5, 1.0)
    chosen = risk_of(risk)
    if drops < 1:
        raise ParameterError(f"drops is {drops!r}: it must be at least 1", field="drops")
    found = Board.named(board)

    def solved(landings: Block) -> Pays:
        return table_for(found, landings, target, chosen)

    def report(first: int, times: int, done: int, of: int) -> None:
        if progress is not None:
            progress(first + done, first + times * of)

    counting = Counting(found, drops, workers or Here(threads))
    # About as many drops judge the table as choose it.
    choosing = counting.until_known(none_yet(found), solved, partial(report, 0, 2))
    pays, first = solved(choosing), sum(each.drops for each in choosing)
    judges = tuple(map(none_after, choosing))
    judging = counting.until_known(judges, lambda _: pays, partial(report, first, 1))
    paying = replace(found, bins=replace(found.bins, multipliers=pays))
    odds = tuple(odds_of(each, pays) for each in judging)
    return Payouts(paying, chosen, target, odds, judging, choosing)


def risk_of(risk: object) -> Risk:
    """Return `risk` if it is valid; ParameterError otherwise."""
    for known in RISKS:
        if risk == known:
            return known
    raise ParameterError(f"risk is {risk!r}: it must be low, medium or high", field="risk")


def table_for(board: Board, landings: Block, target: float, risk: Risk) -> Pays:
    """Solve the multipliers for counted landings; ParameterError if none are within the bounds."""
    chances = np.array([each.chances for each in landings])
    return table.solve(chances, risk, table.bounds_of(target), is_mirrored(board))


def needed(odds: Odds, precise: float) -> int:
    """Drops that make the return known to `precise` (95 %), estimated from `odds`' volatility."""
    return ceil((DEVIATIONS * odds.volatility / precise) ** 2)


@dataclass(frozen=True, slots=True)
class Counting:
    """Counts where the drops of a board land, at most `drops` from each aim."""

    board: Board
    drops: int
    workers: Workers

    def until_known(
        self, begun: Block, pays_of: Callable[[Block], Pays], progress: Progress
    ) -> Block:
        """Add landings until the table's return is known; pays_of: the table for some landings."""
        landings = begun
        wanted = [min(FEWEST, self.drops)] * len(landings)
        while any(each.drops < need for each, need in zip(landings, wanted, strict=True)):
            landings = self._until(landings, wanted, progress)
            pays = pays_of(landings)
            known = [
                needed(odds_of(each, pays), PRECISE_AIM if k else PRECISE)
                for k, each in enumerate(landings)
            ]
            wanted = [min(self.drops, need) for need in known]
        return landings

    def _until(self, landings: Block, wanted: list[int], progress: Progress) -> Block:
        """Add landings until each aim has at least its `wanted` number of drops."""
        counted = list(landings)
        for k, need in enumerate(wanted):
            if counted[k].drops < need:
                before = sum(each.drops for each in counted)
                left = sum(max(n - each.drops, 0) for n, each in zip(wanted, counted, strict=True))
                report = partial(_report, progress, before, before + left)
                some = need - counted[k].drops
                counted[k] = more(self.board, counted[k], some, self.workers, report)
        return tuple(counted)


def _report(progress: Progress, before: int, of: int, done: int) -> None:
    progress(before + done, of)
