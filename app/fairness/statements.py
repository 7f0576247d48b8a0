"""The statements that a server signs: sessions, receipts, heads of the log, restores and keys.

Their JSON form is what is signed, and exports contain it unchanged. Digests, seeds and keys are
hexadecimal; times are Unix time in whole milliseconds; stakes are in minor units.
"""

import hashlib
from dataclasses import asdict, dataclass
from typing import Annotated, ClassVar, Final

from msgspec import Meta

from plinko.app.rooms.canonical import canonical
from plinko.app.rooms.stakes import MAX_PAYOUT
from plinko.engine import Board
from plinko.engine.json_text import JsonObject

VERSION: Final = 1

Count = Annotated[int, Meta(ge=0, le=MAX_PAYOUT)]
"""A number, an amount or a time, which every reader of JSON keeps exactly."""


@dataclass(frozen=True, slots=True)
class _Statement:
    """A signed statement. `KIND` distinguishes it from all other kinds.

    OPTIONAL: fields that the JSON lacks if they are None.
    """

    KIND: ClassVar[str]
    OPTIONAL: ClassVar[tuple[str, ...]] = ()

    def to_dict(self) -> dict[str, object]:
        """The JSON form that is signed."""
        values = asdict(self)
        for name in self.OPTIONAL:
            if values[name] is None:
                del values[name]
        return {"kind": self.KIND, "version": VERSION, **values}


@dataclass(frozen=True, slots=True)
class SessionStatement(_Statement):
    """The conditions of a session, signed before the player opens their secret.

    draw_digest: of the room's draw. Without a draw, the JSON does not have this member.
    """

    KIND: ClassVar[str] = "plinko session"
    OPTIONAL: ClassVar[tuple[str, ...]] = ("draw_digest",)

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
        return canonical(self.to_dict())


@dataclass(frozen=True, slots=True)
class LogEntry(_Statement):
    """A receipt's place in the log: leaf number `index`, after which the log has this root.

    log: the id of the log, if a restore began it.
    """

    KIND: ClassVar[str] = "plinko log entry"
    OPTIONAL: ClassVar[tuple[str, ...]] = ("log",)

    receipt: JsonObject
    index: Count
    root: str
    log: str | None = None


@dataclass(frozen=True, slots=True)
class TreeHead(_Statement):
    """The state of a log: its number of leaves and its root. log: as in `LogEntry`."""

    KIND: ClassVar[str] = "plinko tree head"
    OPTIONAL: ClassVar[tuple[str, ...]] = ("log",)

    size: Count
    root: str
    time: Count
    log: str | None = None


@dataclass(frozen=True, slots=True)
class Closing(_Statement):
    """The end of a session: its number of drops, and the server's secret.

    void: the id of the log that a restore began, if the restore ended the session. Drops that the
    restored backup lacks are void.
    """

    KIND: ClassVar[str] = "plinko session end"
    OPTIONAL: ClassVar[tuple[str, ...]] = ("void",)

    session: str
    drops: Count
    server_seed: str
    time: Count
    void: str | None = None


@dataclass(frozen=True, slots=True)
class RestoreStatement(_Statement):
    """A backup was restored: log `log` begins, empty, where the backup's log ends.

    former: the id of the backup's log, null for a ledger's first one; it keeps `size` leaves and
    this root. superseded: the id of the log that was lost, if the backup knows nothing of it.
    sessions: the number of open sessions, which the restore ended.
    """

    KIND: ClassVar[str] = "plinko restore"

    log: str
    former: str | None
    size: Count
    root: str
    superseded: str | None
    sessions: Count
    time: Count


@dataclass(frozen=True, slots=True)
class KeyStatement(_Statement):
    """The server signs with another key from now on. Both are public keys."""

    KIND: ClassVar[str] = "plinko key"

    key: str
    former: str
    time: Count


def payouts_digest(board: Board) -> str:
    """SHA-256 of the board's multipliers as canonical JSON, in 64 hexadecimal digits."""
    return hashlib.sha256(canonical(list(board.bins.multipliers))).hexdigest()
