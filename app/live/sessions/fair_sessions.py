"""All players' sessions: begun, opened, ended and exported; from the ledger where not in memory.

Nothing is told that is not in the ledger first. So a session outlives the connection, the room's
stay in memory and the server; one that nobody uses ends by itself when somebody asks for it.
"""

import asyncio
import time
from collections import OrderedDict
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Final

import msgspec

from app.errors import (
    InvalidValueError,
    LedgerError,
    SessionStateError,
    UnknownSessionError,
    shorten,
)
from app.fairness.export import KIND, VERSION, DropResult, SessionExport, Signed, make_export
from app.fairness.seeds import SECRET_BYTES, commitment, parse_hex
from app.fairness.signing import Signer
from app.fairness.statements import Closing, SessionStatement, TreeHead, payouts_digest
from app.live.sessions.fair_session import FairSession
from app.persistence.service import PersistenceService
from app.persistence.statements import fair_store
from app.rooms.canonical import canonical
from app.rooms.independent import INDEPENDENT
from app.rooms.outcome import signed
from app.rooms.records import FairEnd, FairOpening, FairSessionRow, ResultRow
from app.rooms.room import Room
from engine import PHYSICS_VERSION, Board, merkle

REST_SECONDS: Final = 86_400.0
"""s without a drop after which a session is over and its seed revealed: a day, so that a player who
closes the page in the evening finds it in the morning."""

_HELD: Final = 10_000  # sessions in memory; the others are in the ledger


class FairSessions:
    """For the event loop's thread. `rest`: seconds without a drop after which a session is over.

    `draw` gives a server's seed, `new_id` the id of a session; `now` is Unix time in seconds. A
    session is where its room is: where servers share the ledger, `having` has a room here for a
    while, even one that is closed.
    """

    def __init__(
        self,
        persistence: PersistenceService,
        signer: Signer,
        *,
        kernel_digest: str,
        rest: float = REST_SECONDS,
        draw: Callable[[int], bytes],
        new_id: Callable[[], str],
        having: Callable[[str], AbstractAsyncContextManager[None]],
        now: Callable[[], float] = time.time,
    ) -> None:
        self.signer = signer
        self.kernel_digest = kernel_digest
        self._persistence = persistence
        self._ledger = persistence.ledger
        self._rest = rest
        self._draw = draw
        self._new_id = new_id
        self._now = now
        self._held: OrderedDict[str, FairSession] = OrderedDict()
        self._having = having

    async def begin(self, room: Room, client_commitment: object) -> FairSession:
        """Commit to a secret of the server's, after the player has committed to theirs.

        Raises InvalidValueError for what is no commitment, or a room where balls touch each other;
        LedgerError, UndecidedError.
        """
        return await self._ledger.decided(self._begin(room, client_commitment))

    async def _begin(self, room: Room, client_commitment: object) -> FairSession:
        if not self._ledger.keeps:
            raise LedgerError("this server keeps no ledger, and so no sessions")
        committed = parse_hex(client_commitment, "commitment")
        board = room.ground
        if room.kind != INDEPENDENT or not isinstance(board, Board):
            raise InvalidValueError(
                f"room {room.id!r} has no sessions: other balls decide where one ends there",
                field="room",
            )
        now = self._now()
        secret = self._draw(SECRET_BYTES)
        began = SessionStatement(
            session=self._new_id(),
            room=room.id,
            board_digest=board.digest,
            payouts_digest=payouts_digest(board),
            physics_version=PHYSICS_VERSION,
            kernel_digest=self.kernel_digest,
            server_commitment=commitment(secret).hex(),
            client_commitment=committed.hex(),
            time=int(now * 1000.0),
            draw_digest=None if room.draw is None else room.draw.digest,
        )
        statement = began.to_dict()
        session = FairSession(
            id=began.session,
            room=room.id,
            board_digest=board.digest,
            server_seed=secret,
            statement=statement,
            signature=self.signer.sign(statement).hex(),
            signer=self.signer,
            used=now,
        )
        row = FairSessionRow(
            id=session.id,
            room=room.id,
            board=board.digest,
            server_seed=secret.hex(),
            statement=canonical(statement).decode(),
            signature=session.signature,
            opened=now,
        )
        await self._ledger.commit(self._persistence.runs.board_row_of(board), row)
        return self._hold(session)

    async def open(self, session: FairSession, client_seed: object) -> None:
        """The player opens their secret; drops can be taken from now on.

        Raises InvalidValueError for what they have not committed to, SessionStateError after the
        end, LedgerError, UndecidedError. The same again changes nothing.
        """
        seed = parse_hex(client_seed, "seed")
        if commitment(seed).hex() != session.statement["client_commitment"]:
            raise InvalidValueError(
                "the seed is not the one that was committed to: its SHA-256 is another",
                field="seed",
            )
        if session.end is not None or session.ending:
            raise SessionStateError(f"session {session.id!r} is over", field="session")
        if session.client_seed is None:
            await self._ledger.decided(self._open(session, seed))

    async def _open(self, session: FairSession, seed: bytes) -> None:
        async with self._having(session.room):
            await self._ledger.commit(FairOpening(session.id, session.room, seed.hex()))
        session.client_seed = seed

    def joined(self, session_id: str) -> FairSession:
        """A session in memory; raises UnknownSessionError for another."""
        found = self._cached(session_id)
        if found is None:
            raise self._unknown(session_id)
        self._held.move_to_end(session_id)
        return found

    def _cached(self, session_id: str) -> FairSession | None:
        """A session in memory, unless its room has left this server since it was read."""
        found = self._held.get(session_id)
        if found is not None and found.lease != self._persistence.lease_of(found.room):
            return None
        return found

    async def find(self, session_id: str) -> FairSession:
        """A session, from the ledger if need be; one that rested too long is over then.

        Raises UnknownSessionError, LedgerError.
        """
        session = self._cached(session_id)
        if session is None:
            row, _, _ = await self._read(session_id)
            async with self._having(row.room):
                # Again, now that no other server adds to it.
                found = await self._read(session_id)
                session = self._cached(session_id) or self._hold(self._restored(*found))
        if session.end is None and self._now() - session.used > self._rest:
            await self.end(session)
        return session

    async def _read(self, session_id: str) -> tuple[FairSessionRow, int, float]:
        found = await self._ledger.read(fair_store.session, session_id=session_id)
        if found is None:
            raise self._unknown(session_id)
        return found

    async def end(self, session: FairSession) -> None:
        """End a session and reveal its secret; nothing new where it is over.

        An end that was begun is tried until it is in the ledger: all who ask get the same one.
        Raises SessionStateError while a drop of it waits for the ledger, LedgerError,
        UndecidedError.
        """
        if session.end is not None:
            return
        if session.ending is None:
            if session.pending:
                raise SessionStateError(
                    f"a drop of session {session.id!r} is being written; try again",
                    field="session",
                )
            session.ending = asyncio.create_task(self._end(session), name=session.id)
        await self._ledger.decided(session.ending)

    async def _end(self, session: FairSession) -> None:
        secret = session.server_seed.hex()
        time_ms = int(self._now() * 1000.0)
        end = Closing(session.id, session.drops, secret, time_ms).to_dict()
        signature = self.signer.sign(end).hex()
        try:
            async with self._having(session.room):
                row = FairEnd(session.id, session.room, canonical(end).decode(), signature)
                await self._ledger.keep(row)
            session.end, session.end_signature = end, signature
        finally:
            session.ending = None

    async def export(self, session: FairSession) -> bytes:
        """The session as JSON; its server seed is null until it is over. Raises LedgerError."""
        self._persistence.runs.report([])
        found = await self._ledger.read(fair_store.exported, session_id=session.id)
        if found is None:
            raise self._unknown(session.id)
        head = TreeHead(
            found.size,
            merkle.root(found.size, _looked_up(found.nodes)).hex(),
            int(self._now() * 1000.0),
        )
        return msgspec.json.encode(self._exported(found, head, over=session.end is not None))

    async def head(self, since: int = 0) -> tuple[Signed, list[str]]:
        """How the log stands, signed, and the proof that it only grew since it had that size.

        Raises InvalidValueError for a size that it has not had, LedgerError.
        """
        count, nodes = await self._ledger.read(fair_store.grown, since=since)
        if since > count:
            raise InvalidValueError(
                f"since {since} is more than the {count} receipts of the log", field="since"
            )
        lookup = _looked_up(nodes)
        head = TreeHead(count, merkle.root(count, lookup).hex(), int(self._now() * 1000.0))
        proof = merkle.consistency(since, count, lookup) if since else []
        return self._signed(head.to_dict()), [node.hex() for node in proof]

    def _exported(self, found: fair_store.Exported, head: TreeHead, *, over: bool) -> SessionExport:
        """`over`: this server knows the session's end as durable; before, no secret is told."""
        row = found.session
        end = row.end if over else None
        bare = SessionExport(
            kind=KIND,
            version=VERSION,
            key=self.signer.public.hex(),
            session=Signed(msgspec.json.decode(row.statement), row.signature),
            board=msgspec.json.decode(found.board),
            draw=msgspec.UNSET if found.draw is None else msgspec.json.decode(found.draw),
            client_seed=row.client_seed,
            server_seed=None if end is None else row.server_seed,
            drops=[],
            head=self._signed(head.to_dict()),
            end=Signed(msgspec.json.decode(end), row.end_signature or "") if end else None,
        )
        drops = [(signed(each), _result(result)) for each, result in found.drops]
        return make_export(bare, drops, _looked_up(found.nodes))

    def _signed(self, statement: dict[str, object]) -> Signed:
        return Signed(statement, self.signer.sign(statement).hex())

    def _restored(self, row: FairSessionRow, drops: int, used: float) -> FairSession:
        statement = msgspec.json.decode(row.statement)
        return FairSession(
            id=row.id,
            room=row.room,
            board_digest=row.board,
            server_seed=bytes.fromhex(row.server_seed),
            statement=statement,
            signature=row.signature,
            signer=self.signer,
            used=used,
            client_seed=None if row.client_seed is None else bytes.fromhex(row.client_seed),
            drops=drops,
            end=None if row.end is None else msgspec.json.decode(row.end),
            end_signature=row.end_signature or "",
        )

    def _hold(self, session: FairSession) -> FairSession:
        session.lease = self._persistence.lease_of(session.room)
        self._held[session.id] = session
        while len(self._held) > _HELD:
            oldest = next(iter(self._held.values()))
            if oldest.pending or oldest.ending:
                break
            del self._held[oldest.id]
        return session

    def _unknown(self, session_id: str) -> UnknownSessionError:
        return UnknownSessionError(
            f"session {shorten(session_id)} is not known, or was not joined here", field="session"
        )


def _looked_up(nodes: fair_store.Nodes) -> merkle.Lookup:
    return lambda level, number: nodes[level, number]


def _result(row: ResultRow | None) -> DropResult | None:
    if row is None:
        return None
    told = [name for name in DropResult.__struct_fields__ if name != "tick"]
    return DropResult(**{name: getattr(row, name) for name in told})
