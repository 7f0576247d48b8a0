"""What the server signs: how a session began, each drop's receipt, how the log stands, the end.

Frozen values with their JSON form, which is what is signed and what an export has, word for word.
Digests, seeds and keys are hexadecimal, times whole milliseconds of Unix time, stakes minor units.
"""

import hashlib
from dataclasses import asdict, dataclass
from typing import Annotated, ClassVar, Final

from msgspec import Meta

from app.rooms.canonical import canonical
from engine import Board
from engine.json_text import JsonObject

VERSION: Final = 1

Count = Annotated[int, Meta(ge=0, le=(1 << 63) - 1)]
"""A number, an amount or a time, as a ledger can hold it."""


@dataclass(frozen=True, slots=True)
class _Statement:
    """Something that is signed; `KIND` tells it from all else that is."""

    KIND: ClassVar[str]

    def to_dict(self) -> dict[str, object]:
        """Its JSON form, all that is signed."""
        return {"kind": self.KIND, "version": VERSION, **asdict(self)}


@dataclass(frozen=True, slots=True)
class SessionStatement(_Statement):
    """What holds for a session, said before the player opens their secret.

    draw_digest: of the room's draw; a room without one has no such member in its JSON.
    """

    KIND: ClassVar[str] = "plinko session"

    session: str
    room: str
    board_digest: str
    payouts_digest: str
    physics_version: Count
    kernel_digest: str
    server_commitment: str
    client_commitment: str
    time: Count
    draw_digest: str | None = None

    def to_dict(self) -> dict[str, object]:
        """Its JSON form, all that is signed."""
        values = _Statement.to_dict(self)
        if self.draw_digest is None:
            del values["draw_digest"]
        return values


@dataclass(frozen=True, slots=True)
class Receipt(_Statement):
    """Drop `drop` of a session, before it is computed. A leaf of the log."""

    KIND: ClassVar[str] = "plinko receipt"

    session: str
    drop: Count
    stake: Count
    aim: float | None
    seed: str
    board_digest: str
    room: str
    ball: Count
    time: Count

    def leaf(self) -> bytes:
        """Its bytes in the log."""
        return canonical(self.to_dict())


@dataclass(frozen=True, slots=True)
class LogEntry(_Statement):
    """The place of a receipt in the log: leaf `index`, with which the log has this root."""

    KIND: ClassVar[str] = "plinko log entry"

    receipt: JsonObject
    index: Count
    root: str


@dataclass(frozen=True, slots=True)
class TreeHead(_Statement):
    """How the log stands: its leaves are `size`, their root is this."""

    KIND: ClassVar[str] = "plinko tree head"

    size: Count
    root: str
    time: Count


@dataclass(frozen=True, slots=True)
class Closing(_Statement):
    """The end of a session: it has had so many drops, and the server's secret was this."""

    KIND: ClassVar[str] = "plinko session end"

    session: str
    drops: Count
    server_seed: str
    time: Count


def payouts_digest(board: Board) -> str:
    """SHA-256 of the board's multipliers as canonical JSON, 64 hexadecimal digits."""
    return hashlib.sha256(canonical(list(board.bins.multipliers))).hexdigest()
