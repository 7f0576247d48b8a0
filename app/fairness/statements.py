"""The statements that a server signs: a session's beginning and end, receipts, heads of the log.

Their JSON form is what is signed, and exports contain it unchanged. Digests, seeds and keys are
hexadecimal; times are Unix time in whole milliseconds; stakes are in minor units.
"""

import hashlib
from dataclasses import asdict, dataclass
from typing import Annotated, ClassVar, Final

from msgspec import Meta

from app.rooms.canonical import canonical
from app.rooms.stakes import MAX_PAYOUT
from engine import Board
from engine.json_text import JsonObject

VERSION: Final = 1

Count = Annotated[int, Meta(ge=0, le=MAX_PAYOUT)]
"""A number, an amount or a time, which every reader of JSON keeps exactly."""


@dataclass(frozen=True, slots=True)
class _Statement:
    """A signed statement. `KIND` distinguishes it from all other kinds."""

    KIND: ClassVar[str]

    def to_dict(self) -> dict[str, object]:
        """The JSON form that is signed."""
        return {"kind": self.KIND, "version": VERSION, **asdict(self)}


@dataclass(frozen=True, slots=True)
class SessionStatement(_Statement):
    """The conditions of a session, signed before the player opens their secret.

    draw_digest: of the room's draw. Without a draw, the JSON does not have this member.
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
        values = _Statement.to_dict(self)
        if self.draw_digest is None:
            del values["draw_digest"]
        return values


@dataclass(frozen=True, slots=True)
class Receipt(_Statement):
    """Drop number `drop` of a session, signed before it is computed. A leaf of the log."""

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
        """The bytes of the leaf."""
        return canonical(self.to_dict())


@dataclass(frozen=True, slots=True)
class LogEntry(_Statement):
    """A receipt's place in the log: leaf number `index`, after which the log has this root."""

    KIND: ClassVar[str] = "plinko log entry"

    receipt: JsonObject
    index: Count
    root: str


@dataclass(frozen=True, slots=True)
class TreeHead(_Statement):
    """The state of the log: its number of leaves and its root."""

    KIND: ClassVar[str] = "plinko tree head"

    size: Count
    root: str
    time: Count


@dataclass(frozen=True, slots=True)
class Closing(_Statement):
    """The end of a session: its number of drops, and the server's secret."""

    KIND: ClassVar[str] = "plinko session end"

    session: str
    drops: Count
    server_seed: str
    time: Count


def payouts_digest(board: Board) -> str:
    """SHA-256 of the board's multipliers as canonical JSON, in 64 hexadecimal digits."""
    return hashlib.sha256(canonical(list(board.bins.multipliers))).hexdigest()
