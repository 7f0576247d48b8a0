"""One player's session while it is in memory: its next drop, and what may be done in it. No I/O.

The numbers of its drops have no gaps: one that the ledger refuses gives its number back, the latest
first, as the ledger tells it (app/persistence/ledger/commit_queue.py).
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from app.errors import InvalidValueError, LimitError, SessionStateError
from app.fairness.seeds import draw_mac, drop_seed
from app.fairness.signing import Signer
from app.fairness.statements import LogEntry, Receipt
from app.protocol import messages
from app.rooms.draw import Draw
from app.rooms.pending import Pending
from app.rooms.records import Lease, LogLeaf
from app.rooms.room import Room

MOST_DROPS: Final = 1000
"""Drops of one session: an export is read from the ledger at one stroke, while commits wait."""


@dataclass(slots=True, eq=False)
class FairSession:
    """A session of one player in one room. Seeds are its secrets, 32 bytes each.

    statement, signature: what the server signed at its beginning. drops: how many it has had, those
    included that wait for the ledger, which are `pending`. used: when something happened last.
    lease: under which its room was here when it was read, where servers share the ledger.
    """

    id: str
    room: str
    board_digest: str
    server_seed: bytes
    statement: dict[str, object]
    signature: str
    signer: Signer
    used: float
    client_seed: bytes | None = None
    drops: int = 0
    pending: int = 0
    end: dict[str, object] | None = None
    end_signature: str = ""
    ending: "asyncio.Task[None] | None" = None
    lease: Lease | None = None

    def check(self, room: Room, *, practice: bool) -> None:
        """Raise unless a drop can be taken into `room` now; `practice`: with a seed or an x.

        InvalidValueError, LimitError, SessionStateError.
        """
        if practice:
            raise InvalidValueError(
                "a drop of a session has neither seed nor x: nobody chooses its start; a drop "
                "with one is practice, without session and stake",
                field="session",
            )
        if self.room != room.id:
            raise SessionStateError(
                f"session {self.id!r} is of room {self.room!r}, not {room.id!r}", field="session"
            )
        if self.board_digest != room.ground.digest:
            raise SessionStateError(
                f"room {room.id!r} has another board than session {self.id!r} began on; end it "
                "and begin another",
                field="session",
            )
        if self.statement.get("draw_digest") != (room.draw and room.draw.digest):
            raise SessionStateError(
                f"room {room.id!r} has another draw than session {self.id!r} began with; end it "
                "and begin another",
                field="session",
            )
        self._check_open()
        if self.drops >= MOST_DROPS:
            raise LimitError(
                f"session {self.id!r} has had its {MOST_DROPS} drops; end it and begin another",
                field="session",
            )

    def _check_open(self) -> None:
        if self.end is not None or self.ending:
            raise SessionStateError(f"session {self.id!r} is over", field="session")
        if self.client_seed is None:
            raise SessionStateError(
                f"session {self.id!r} is not open yet: send the seed that you committed to",
                field="session",
            )

    def next_seed(self, draw: Draw | None) -> int:
        """The seed of the next drop, once the session is open, in a room with this draw."""
        assert self.client_seed is not None
        digest = bytes.fromhex(self.board_digest)
        known = (self.server_seed, self.client_seed, self.drops, digest)
        if draw is None:
            return drop_seed(*known)
        _, seed = draw.pick(draw_mac(*known))
        return seed

    def take(self, pending: Pending, room_session: int, now: float) -> "TakenDrop":
        """The next drop is this one, of the room's session of this number; `now` in Unix time."""
        command = pending.command
        receipt = Receipt(
            session=self.id,
            drop=self.drops,
            stake=command.stake,
            aim=command.aim,
            seed=str(command.seed),
            board_digest=self.board_digest,
            room=self.room,
            ball=pending.number,
            time=int(now * 1000.0),
        )
        values = receipt.to_dict()
        leaf = LogLeaf(
            session=self.id,
            number=self.drops,
            room=room_session,
            ball=pending.number,
            receipt=values,
            leaf=receipt.leaf(),
            sign=_signs(self.signer, values),
        )
        self.drops += 1
        self.pending += 1
        self.used = now
        return TakenDrop(self, leaf)

    def state(self, *, token: str | None = None, ref: object = None) -> messages.SessionState:
        """What its player is told of it."""
        return messages.SessionState(
            session=self.id,
            room=self.room,
            statement=self.statement,
            signature=self.signature,
            key=self.signer.public.hex(),
            open=self.client_seed is not None,
            drops=self.drops,
            ended=self.end is not None,
            token=token,
            ref=ref,
        )

    def ended(self, *, ref: object = None) -> messages.SessionEnded:
        """What its player is told at the end; raises SessionStateError before it."""
        if self.end is None:
            raise SessionStateError(f"session {self.id!r} is not over", field="session")
        return messages.SessionEnded(
            session=self.id,
            server_seed=self.server_seed.hex(),
            statement=self.end,
            signature=self.end_signature,
            ref=ref,
        )


@dataclass(frozen=True, slots=True)
class TakenDrop:
    """A drop of a session that the ledger has not taken yet."""

    session: FairSession
    leaf: LogLeaf

    def settled(self, *, refused: bool) -> messages.SignedReceipt | None:
        """The ledger has it, or never will; returns its receipt where it has."""
        self.session.pending -= 1
        if refused:
            self.session.drops -= 1
            return None
        leaf = self.leaf
        assert leaf.index is not None
        return messages.SignedReceipt(leaf.receipt, leaf.index, leaf.root, leaf.signature)


def _signs(signer: Signer, receipt: dict[str, object]) -> Callable[[int, str], str]:
    """What signs a receipt with its place, in hexadecimal."""

    def sign(index: int, root: str) -> str:
        return signer.sign(LogEntry(receipt, index, root).to_dict()).hex()

    return sign
