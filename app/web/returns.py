"""Metrics of payouts: what boards paid back of the stakes, and what they should have paid."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt
from typing import Final

from plinko.app.errors import LedgerError
from plinko.app.ops.metrics import Reading
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import totals
from plinko.app.persistence.statements.totals import Total
from plinko.engine import Board
from plinko.engine.board.payouts import NAMES
from plinko.engine.board.presets import risk_of
from plinko.engine.payouts.record import odds_of_record

DEVIATIONS: Final = 4.0
"""k of the tolerance k sigma / sqrt(n). By chance alone one check in 16,000 exceeds it."""

OTHER: Final = "other"
"""The label of all boards that are not presets: their expected return is not known."""


@dataclass
class Returns:
    """The totals of all drops with a stake since the ledger began."""

    ledger: Ledger
    found: tuple[Total, ...] = ()

    async def refresh(self) -> None:
        """Read the totals from the ledger; if it does not answer, keep the last ones."""
        try:
            self.found = tuple(await self.ledger.read(totals.read))
        except LedgerError:
            return  # plinko_ledger_up reports it

    def readings(self) -> Iterator[Reading]:
        """Sums and returns by board, risk, size of stake, and whether the players aimed."""
        for total in self._merged():
            name = NAMES.get(total.board)
            labels = {
                "board": name or OTHER,
                "risk": risk_of(name) if name else OTHER,
                "stake": str(total.stake),
                "aimed": "yes" if total.aimed else "no",
            }
            yield "plinko_plays_total", "Drops with a stake that ended.", total.plays, labels
            yield "plinko_staked_total", "Minor units staked on them.", total.staked, labels
            yield "plinko_paid_total", "Minor units paid for them.", total.paid, labels
            if name is not None and not total.aimed:
                yield from _judged(Board.preset(name), total, labels)

    def _merged(self) -> list[Total]:
        """The totals, with one for all boards that are not presets, so that labels stay few."""
        merged: dict[tuple[str, int, bool], Total] = {}
        for each in self.found:
            board = each.board if each.board in NAMES else OTHER
            into = merged.setdefault(
                (board, each.stake, each.aimed), Total(board, each.stake, each.aimed)
            )
            into.plays += each.plays
            into.staked += each.staked
            into.squares += each.squares
            into.paid += each.paid
        return list(merged.values())


def _judged(board: Board, total: Total, labels: dict[str, str]) -> Iterator[Reading]:
    """A preset's actual and expected return; nothing if the record has no odds of it."""
    counted = odds_of_record(board)
    if not counted:
        return
    odds = counted[0]
    actual, may_differ = total.paid / total.staked, tolerance(total, odds.volatility, odds.doubt)
    yield "plinko_return", "Share of the stakes that was paid back.", actual, labels
    yield "plinko_return_expected", "Share that should be paid back.", odds.returned, labels
    yield "plinko_return_tolerance", "How far the two may differ.", may_differ, labels


def tolerance(total: Total, sigma: float, doubt: float) -> float:
    """How far the actual return may be from the expected one, whose uncertainty is `doubt`.

    sigma: the standard deviation of the payout of a stake of 1. For n equal stakes the tolerance
    from chance is k sigma / sqrt(n). Added to it are the doubt, and the loss by rounding down,
    which is less than one minor unit per play.
    """
    chance = DEVIATIONS * sigma * sqrt(total.squares) / total.staked
    return chance + doubt + total.plays / total.staked
