"""The outcome of a drop: its result, and the events that clients receive."""

from dataclasses import dataclass

import msgspec

from plinko.app.protocol import messages
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.records import DropRow, ResultRow
from plinko.app.rooms.room import Basis
from plinko.app.rooms.stakes import payout_of
from plinko.engine import Board
from plinko.engine.drops.flight import Flight, fly
from plinko.engine.drops.start import start_of


@dataclass(frozen=True, slots=True)
class Outcome:
    """An accepted drop and its landing; `landed` is None while the ball falls.

    earlier: the client repeats a request, and the drop was accepted before.
    """

    accepted: messages.Accepted
    landed: messages.Landed | None = None
    earlier: bool = False


def accepted_of(
    board: Board, fact: DropRow, receipt: messages.SignedReceipt | None
) -> messages.Accepted:
    return messages.Accepted(
        ball=fact.ball,
        seed=str(fact.seed),
        x=start_of(board, fact.seed, fact.x, fact.aim),
        explicit_x=fact.x is not None,
        aim=msgspec.UNSET if fact.aim is None else fact.aim,
        tick=fact.tick,
        stake=fact.stake or msgspec.UNSET,
        practice=fact.practice or msgspec.UNSET,
        receipt=receipt or msgspec.UNSET,
        **fact.tag.fields,
    )


def computed(basis: Basis, fact: DropRow, tick_rate: int) -> ResultRow:
    """The result of a fact on this board, or on the board of this draw."""
    board = basis.board if isinstance(basis, Draw) else basis
    assert isinstance(board, Board)
    flight = fly(board, start_of(board, fact.seed, fact.x, fact.aim))
    return result_of(fact, flight, 1.0 / tick_rate)


def result_of(fact: DropRow, flight: Flight, dt: float) -> ResultRow:
    """The end of a fact's flight, in a room with ticks of `dt` s."""
    return ResultRow(
        room=fact.room,
        ball=fact.ball,
        tick=fact.tick + flight.ticks(dt),
        bin=flight.bin,
        score=flight.score,
        t=flight.duration,
        x_end=flight.x_end,
        digest=flight.digest,
        unsettled=flight.unsettled,
        payout=payout_of(fact.stake, flight.score),
    )


def landed_of(board: Board, fact: DropRow, result: ResultRow) -> messages.Landed:
    return messages.Landed(
        ball=fact.ball,
        seed=str(fact.seed),
        bin=result.bin,
        score=result.score,
        tick=result.tick,
        t=result.t,
        x_end=result.x_end,
        digest=result.digest or None,
        unsettled=result.unsettled,
        payout=result.payout if fact.stake else msgspec.UNSET,
        practice=fact.practice or msgspec.UNSET,
        label=board.bins.label_of(result.bin) or msgspec.UNSET,
        **fact.tag.fields,
    )


def outcome_of(
    board: Board,
    fact: DropRow,
    receipt: messages.SignedReceipt | None,
    result: ResultRow | None,
) -> Outcome:
    """The outcome of an earlier drop on this board, from the ledger's rows."""
    landed = None if result is None else landed_of(board, fact, result)
    return Outcome(accepted_of(board, fact, receipt), landed, earlier=True)
