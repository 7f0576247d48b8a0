"""A fair session in memory: checks its drops, and makes each one's seed and receipt. No I/O.

The numbers of its drops are given in the writer's turn (app/persistence/statements/facts.py), where
the seed and the receipt are made too, by functions of this module.
"""

import asyncio
from dataclasses import dataclass
from typing import Final

from plinko.app.errors import InvalidValueError, LimitError, SessionStateError
from plinko.app.fairness.seeds import draw_mac, drop_seed
from plinko.app.fairness.signing import Signer
from plinko.app.fairness.statements import LogEntry, Receipt
from plinko.app.protocol import messages
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.records import DropRow, Lease, LogLeaf, NewDrop, SessionTurn
from plinko.app.rooms.room import Room

MOST_DROPS: Final = 1000
"""In one session: an export is read from the ledger in one go, while commits wait."""


@dataclass(slots=True, eq=False)
class FairSession:
    """A session of one player in one room.

    server_seed, client_seed: the secrets, 32 bytes each; the player's is None until revealed.
    statement, signature: what the server signed, under its public `key`, when the session began.
    signer: signs what comes.
    used: Unix time of the last drop (before the first, of the beginning), in s.
    drops: number of drops that are known to be durable.
    lease: the room's lease when the session was read, if servers share the ledger.
    """

    id: str
    room: str
    board_digest: str
    server_seed: bytes
    statement: dict[str, object]
    signature: str
    key: str
    signer: Signer
    used: float
    client_seed: bytes | None = None
    drops: int = 0
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
                f"the board of room {room.id!r} has changed since session {self.id!r} began; end "
                "the session and begin another",
                field="session",
            )
        if self.statement.get("draw_digest") != (room.draw and room.draw.digest):
            raise SessionStateError(
                f"the draw of room {room.id!r} has changed since session {self.id!r} began; end "
                "the session and begin another",
                field="session",
            )
        self._check_open()
        if self.drops >= MOST_DROPS:
            raise LimitError(
                f"session {self.id!r} has had its {MOST_DROPS} drops; end it and begin another",
                field="session",
            )

    def _check_open(self) -> None:
        if self.void:
            raise SessionStateError(
                f"session {self.id!r} is over: the operator restored a backup of the ledger, and "
                "the drops that it lacks are void; begin another session",
                field="session",
            )
        if self.end is not None or self.ending:
            raise SessionStateError(f"session {self.id!r} is over", field="session")
        if self.client_seed is None:
            raise SessionStateError(
                f"session {self.id!r} is not open yet: send the seed that you committed to",
                field="session",
            )

    @property
    def void(self) -> bool:
        """Whether the restore of a backup ended the session."""
        return self.end is not None and "void" in self.end

    def turn(self, draw: Draw | None, now: float) -> SessionTurn:
        """For the writer's turn: how to make the next drop in a room with this draw, if any."""
        digest, client_seed = bytes.fromhex(self.board_digest), self.client_seed
        assert client_seed is not None

        def seed_of(number: int) -> int:
            known = (self.server_seed, client_seed, number, digest)
            return drop_seed(*known) if draw is None else draw.pick(draw_mac(*known))[1]

        def leaf(number: int, fact: DropRow) -> LogLeaf:
            receipt = Receipt(
                session=self.id,
                drop=number,
                stake=fact.stake,
                aim=fact.aim,
                seed=str(fact.seed),
                board_digest=self.board_digest,
                room=self.room,
                ball=fact.ball,
                time=int(now * 1000.0),
            )
            values = receipt.to_dict()

            def sign(index: int, root: str, log: str | None) -> str:
                return self.signer.sign(LogEntry(values, index, root, log).to_dict()).hex()

            return LogLeaf(self.id, number, fact.room, fact.ball, values, receipt.leaf(), sign)

        return SessionTurn(self.id, MOST_DROPS, seed_of, leaf)

    def took(self, request: NewDrop) -> None:
        """Note that a drop is durable."""
        if request.session is not None and not request.earlier:
            self.drops = max(self.drops, request.session.n + 1)
            self.used = request.used

    def state(self, *, token: str | None = None, ref: object = None) -> messages.SessionState:
        """The event that shows the session to its player."""
        return messages.SessionState(
            session=self.id,
            room=self.room,
            statement=self.statement,
            signature=self.signature,
            key=self.key,
            open=self.client_seed is not None,
            drops=self.drops,
            ended=self.end is not None,
            void=self.void,
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
