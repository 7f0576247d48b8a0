"""The outcome of a drop in the ledger, as the events that clients received at the time."""

from dataclasses import dataclass

import msgspec

from app.protocol import messages
from app.rooms.records import DropRow, ReceiptRow, ResultRow
from app.rooms.room import Ground
from engine import Board
from engine.drops.start import start_of


@dataclass(frozen=True, slots=True)
class Outcome:
    """An accepted drop and its landing; `landed` is None while the ball falls.

    earlier: the client repeats a request, and the drop was accepted before.
    """

    accepted: messages.Accepted
    landed: messages.Landed | None = None
    earlier: bool = False


def signed(row: ReceiptRow) -> messages.SignedReceipt:
    receipt = msgspec.json.decode(row.receipt)
    return messages.SignedReceipt(receipt, row.leaf, row.root, row.signature)


def outcome_of(
    ground: Ground, row: DropRow, receipt: ReceiptRow | None, result: ResultRow | None
) -> Outcome:
    """The outcome of a drop on this board, from the ledger's rows."""
    assert isinstance(ground, Board)
    accepted = messages.Accepted(
        ball=row.ball,
        seed=str(row.seed),
        x=start_of(ground, row.seed, row.x, row.aim),
        explicit_x=row.x is not None,
        aim=msgspec.UNSET if row.aim is None else row.aim,
        tick=row.tick,
        stake=row.stake or msgspec.UNSET,
        practice=row.practice or msgspec.UNSET,
        receipt=msgspec.UNSET if receipt is None else signed(receipt),
        **row.tag.fields,
    )
    if result is None:
        return Outcome(accepted, earlier=True)
    landed = messages.Landed(
        ball=row.ball,
        seed=str(row.seed),
        bin=result.bin,
        score=result.score,
        tick=result.tick,
        t=result.t,
        x_end=result.x_end,
        digest=result.digest or None,
        unsettled=result.unsettled,
        payout=result.payout if row.stake else msgspec.UNSET,
        practice=row.practice or msgspec.UNSET,
        label=ground.bins.label_of(result.bin) or msgspec.UNSET,
        **row.tag.fields,
    )
    return Outcome(accepted, landed, earlier=True)
