"""Inputs of a room on their way: the command, the planned input, the input carried out."""

import hashlib
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from app.errors import MissingBallError
from app.protocol import messages
from app.protocol.visitors import NO_TAG, Tag

Command = TypeVar("Command")


@dataclass(frozen=True, slots=True)
class DropCommand:
    """A drop that a client asks for, with 0 <= seed < 2^64.

    x: the start in m, if the player chose it.
    stake: in minor units.
    who: the player's mark, which the ledger keeps with the drop.
    aim: the middle, in m, of the interval from which the seed draws the start, if the player chose
    it.
    start: the start in m, which the room sets when it has validated the command.
    practice: the player chose seed or x.
    tag: the player's name and colour, shown to spectators.
    """

    seed: int
    x: float | None = None
    stake: int = 0
    who: str | None = None
    aim: float | None = None
    start: float | None = None
    practice: bool = False
    tag: Tag = NO_TAG


def again_of(kind: str, *parts: str) -> str:
    """The ledger's key for a request that a client may repeat: a hash of its parts, 64 hex digits.

    Clients choose their keys; the hash bounds their length and keeps kinds of request apart.
    """
    return hashlib.sha256("\0".join((kind, *parts)).encode()).hexdigest()


@dataclass(slots=True, eq=False)
class PendingInput(Generic[Command]):
    """A drop or change, planned as input `number` of its room, to be carried out at `tick`.

    again: the key by which the ledger recognises a repeated request, unique in its room run.
    receipt: the receipt of a fair session's drop, once it is in the log.
    """

    number: int
    tick: int
    command: Command
    durable: bool = False
    again: str | None = None
    receipt: messages.SignedReceipt | None = None


Pending = PendingInput[Any]
"""A planned input of either kind of room."""


@dataclass(frozen=True, slots=True)
class Entered:
    """An input that was just carried out, and the events to announce.

    restarts: the input was a reset, so every client needs a new hello.
    failed: why the input had no effect, for its client: its ball has gone since it was planned.
    """

    pending: Pending
    events: list[messages.Event]
    restarts: bool = False
    failed: MissingBallError | None = None
