"""Inputs of a room on their way: the command, the planned input, the input carried out."""

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from plinko.app.errors import MissingBallError
from plinko.app.protocol import messages
from plinko.app.protocol.visitors import NO_TAG, Tag

Command = TypeVar("Command")


@dataclass(frozen=True, slots=True)
class DropCommand:
    """A drop that a client asks for, with 0 <= seed < 2^64.

    x: the start in m, if the player chose it.
    stake: in minor units.
    who: the player's mark, which the ledger keeps with the drop.
    aim: the middle, in m, of the interval from which the seed draws the start, if the player chose
    it.
    practice: the player chose seed or x.
    tag: the player's name and colour, shown to spectators.
    """

    seed: int
    x: float | None = None
    stake: int = 0
    who: str | None = None
    aim: float | None = None
    practice: bool = False
    tag: Tag = NO_TAG


@dataclass(slots=True, eq=False)
class PendingInput(Generic[Command]):
    """An input of a room of touching balls, planned to be carried out at `tick`.

    number: in its room run; a ledger gives it when the input becomes durable, or else the room.
    """

    tick: int
    command: Command
    durable: bool = False
    number: int | None = None


Pending = PendingInput[Any]
"""A planned input of a room of touching balls."""


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
