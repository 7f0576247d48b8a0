"""A fair session in memory: checks its drops, and gives each its seed, number and receipt. No I/O.

The numbers have no gaps. A drop that the ledger refuses gives its number back; that works because
the ledger reports refusals latest first (app/persistence/ledger/commit_queue.py).
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
"""In one session: an export is read from the ledger in one go, while commits wait."""


@dataclass(slots=True, eq=False)
class FairSession:
    """A session of one player in one room.

    server_seed, client_seed: the secrets, 32 bytes each; the player's is None until revealed.
    statement, signature: what the server signed when the session began.
    used: Unix time of the last drop (before the first, of the beginning), in s.
    drops: number of drops, including `pending` ones that wait for the ledger.
    lease: the room's lease when the session was read, if servers share the ledger.
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
        """Raise an error if the session cannot take a drop in `room` now.

        Raises InvalidValueError for a `practice` drop (with a seed or x), LimitError,
        SessionStateError.
        """
        if practice:
            raise InvalidValueError(
                "a drop of a session has neither seed nor x; to choose one for practice, leave "
                "session and stake out",
                field="session",
            )
        if self.room != room.id:
            raise SessionStateError(
                f"session {self.id!r} belongs to room {self.room!r}, not {room.id!r}",
                field="session",
            )
        if self.board_digest != room.ground.digest:
            raise SessionStateError(
                f"room {room.id!r} has another board than when session {self.id!r} began; end the "
                "session and begin another",
                field="session",
            )
        if self.statement.get("draw_digest") != (room.draw and room.draw.digest):
            raise SessionStateError(
                f"room {room.id!r} has another draw than when session {self.id!r} began; end the "
                "session and begin another",
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
        """The seed of the next drop of an open session, in a room with this draw, if any."""
        assert self.client_seed is not None
        digest = bytes.fromhex(self.board_digest)
        known = (self.server_seed, self.client_seed, self.drops, digest)
        if draw is None:
            return drop_seed(*known)
        _, seed = draw.pick(draw_mac(*known))
        return seed

    def take(self, pending: Pending, run: int, now: float) -> "TakenDrop":
        """Make a planned drop of room run `run` the next one of the session; `now`: Unix time."""
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
            room=run,
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
        """The event that shows the session to its player."""
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
        """The event that reveals the server's secret; raises SessionStateError before the end."""
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
    """A drop of a session that waits for the ledger."""

    session: FairSession
    leaf: LogLeaf

    def settled(self, *, refused: bool) -> messages.SignedReceipt | None:
        """Called when the ledger has committed or refused the drop; returns its receipt, if any."""
        self.session.pending -= 1
        if refused:
            self.session.drops -= 1
            return None
        leaf = self.leaf
        assert leaf.index is not None
        return messages.SignedReceipt(leaf.receipt, leaf.index, leaf.root, leaf.signature)


def _signs(signer: Signer, receipt: dict[str, object]) -> Callable[[int, str], str]:
    """A function that signs a receipt with its index and root; the signature is hexadecimal."""

    def sign(index: int, root: str) -> str:
        return signer.sign(LogEntry(receipt, index, root).to_dict()).hex()

    return sign
