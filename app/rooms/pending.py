"""What a room was asked for and has not carried out yet."""

import hashlib
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from app.errors import MissingBallError
from app.protocol import messages
from app.protocol.visitors import NO_TAG, Tag

Command = TypeVar("Command")


@dataclass(frozen=True, slots=True)
class DropCommand:
    """Put a ball in: 0 <= seed < 2^64, and `x` in metres where the player chose the start.

    `stake` is in minor units, `who` a mark of the player's own. `aim`: the middle, in metres, of
    what the seed draws, where the player chose it. `start`: where the ball starts, in metres, once
    a room has found all that valid. `practice`: the player chose seed or x. `tag`: whose it is, for
    those who watch.
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
    """What the ledger has in place of a client's own key: 64 hex digits."""
    return hashlib.sha256("\0".join((kind, *parts)).encode()).hexdigest()


@dataclass(slots=True, eq=False)
class PendingInput(Generic[Command]):
    """A drop or a change that will be number `number` of its room, carried out at `tick`.

    again: by which the same input may be asked for again, unique in its room run.
    receipt: that of a drop of a session, once it is in the log.
    """

    number: int
    tick: int
    command: Command
    durable: bool = False
    again: str | None = None
    receipt: messages.SignedReceipt | None = None


Pending = PendingInput[Any]
"""That of any kind of room."""


@dataclass(frozen=True, slots=True)
class Entered:
    """An input that was carried out just now, and what to tell of it.

    begins_anew: it put another scene in the place of what was there, so that everyone starts over.
    failed: why nothing came of it, for who asked; what it was about has gone since it was planned.
    """

    pending: Pending
    events: list[messages.Event]
    begins_anew: bool = False
    failed: MissingBallError | None = None
