"""All players' fair sessions: begins, opens, ends and exports them, from memory or the ledger.

Each step is committed before its answer is sent. A session therefore survives its connection, its
room's stay in memory and the server. One that has been unused for a day ends at the next request
for it.
"""

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Final

import msgspec

from plinko.app.errors import InvalidValueError, SessionStateError, UnknownSessionError
from plinko.app.fairness.export import (
    KIND,
    VERSION,
    DropResult,
    KeyChange,
    SessionExport,
    Signed,
    make_export,
)
from plinko.app.fairness.seeds import SECRET_BYTES, commitment, parse_hex
from plinko.app.fairness.signing import Signer, is_signed
from plinko.app.fairness.statements import Closing, SessionStatement, TreeHead, payouts_digest
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.persistence.service import PersistenceService
from plinko.app.persistence.signing_key import SigningKey
from plinko.app.persistence.statements import fair_store, history
from plinko.app.rooms.canonical import canonical
from plinko.app.rooms.independent import INDEPENDENT
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.records import FairEnd, FairOpening, FairSessionRow, ResultRow
from plinko.app.rooms.room import Room
from plinko.engine import PHYSICS_VERSION, Board, merkle
from plinko.engine.errors import shorten

REST_SECONDS: Final = 86_400.0
"""s without a drop after which a session ends and its seed is revealed: a day, so that a player who
closes the page in the evening finds it in the morning."""

_IN_MEMORY: Final = 10_000  # sessions in memory; the ledger has all


class FairSessions:
    """For the event loop's thread.

    rest: s without a drop after which a session ends.
    draw: returns n random bytes, for a server's secret.
    new_id: makes the id of a session.
    having: has a room's lease for a while, even if the room is closed: where servers share the
    ledger, only the server with the room changes its sessions.
    now: returns Unix time in s; by default the time of the ledger's records.
    """

    def __init__(
        self,
        persistence: PersistenceService,
        key: SigningKey,
        *,
        kernel_digest: str,
        rest: float = REST_SECONDS,
        draw: Callable[[int], bytes],
        new_id: Callable[[], str],
        having: Callable[[str], AbstractAsyncContextManager[None]],
        now: Callable[[], float] | None = None,
    ) -> None:
        self.key = key
        self.kernel_digest = kernel_digest
        self._persistence = persistence
        self._ledger = persistence.ledger
        self._rest = rest
        self._draw = draw
        self._new_id = new_id
        self._now = now or persistence.now
        self._sessions: OrderedDict[str, FairSession] = OrderedDict()
        self._having = having
        self._key_rows: list[history.KeyRow] = []
        self.restores: list[Signed] = []

    async def load(self) -> None:
        """Read what happened to the ledger: its restores and keys; raises LedgerError.

        Neither changes while a server runs.
        """
        found = await self._ledger.read(history.restores)
        self.restores = [Signed(msgspec.json.decode(r.statement), r.signature) for r in found]
        self._key_rows = await self._ledger.read(history.keys, name=history.STATEMENTS)

    @property
    def signer(self) -> Signer:
        """Signs with the ledger's present key."""
        return self.key.signer

    @property
    def key_changes(self) -> list[KeyChange]:
        """The changes of the server's key, the latest first."""
        return [
            KeyChange(msgspec.json.decode(row.statement), row.signature, row.former_signature)
            for row in reversed(self._key_rows)
            if row.statement is not None and row.signature is not None
        ]

    def _key_of(self, row: FairSessionRow) -> str:
        """The public key that signed a session's statement, among all that the server has had."""
        statement, signature = msgspec.json.decode(row.statement), bytes.fromhex(row.signature)
        for key in (each.value for each in reversed(self._key_rows)):
            if is_signed(statement, signature, bytes.fromhex(key)):
                return key
        return self.signer.public.hex()

    async def begin(
        self, room: Room, client_commitment: object, use: KeyUse | None = None
    ) -> FairSession:
        """Begin a session: commit to a secret of the server, after the player's commitment.

        If the `use` of the key is not new, returns the session that the first request has begun.
        Raises InvalidValueError for an invalid commitment or a room of touching balls,
        KeyReusedError, LedgerError, UndecidedError.
        """
        return await self._ledger.decided(self._begin(room, client_commitment, use or KeyUse()))

    async def _begin(self, room: Room, client_commitment: object, use: KeyUse) -> FairSession:
        committed = parse_hex(client_commitment, "commitment")
        board = room.ground
        if room.kind != INDEPENDENT or not isinstance(board, Board):
            raise InvalidValueError(
                f"room {room.id!r} has no fair sessions, because its balls touch each other: begin "
                "one in a room of independent balls",
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
        row = FairSessionRow(
            id=began.session,
            room=room.id,
            board=board.digest,
            server_seed=secret.hex(),
            statement=canonical(statement).decode(),
            signature=self.signer.sign(statement).hex(),
            opened=now,
        )
        runs = self._persistence.runs
        use.run, use.fact = runs.of(room).number, row.id
        await self._ledger.commit(runs.board_row(board), row, use=use)
        if use.earlier is not None:
            return await self.find(use.earlier.fact)
        return self._remember(self._restored(row, 0, now))

    async def open(self, session: FairSession, client_seed: object) -> None:
        """Take the player's secret; from now on the session takes drops.

        Repeating the call does nothing. Raises InvalidValueError if the secret does not match the
        commitment, SessionStateError after the end, LedgerError, UndecidedError.
        """
        seed = parse_hex(client_seed, "seed")
        if commitment(seed).hex() != session.statement["client_commitment"]:
            raise InvalidValueError(
                "the seed does not match the commitment: its SHA-256 differs",
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
        """A session that is in memory; raises UnknownSessionError for any other."""
        found = self._cached(session_id)
        if found is None:
            raise self._unknown(session_id)
        self._sessions.move_to_end(session_id)
        return found

    def _cached(self, session_id: str) -> FairSession | None:
        """A session in memory; None if its room has left this server since it was read."""
        found = self._sessions.get(session_id)
        if found is not None and found.lease != self._persistence.leases.book.of(found.room):
            return None
        return found

    async def find(self, session_id: str) -> FairSession:
        """A session, from the ledger if necessary; ends it if it was unused for too long.

        Raises UnknownSessionError, LedgerError.
        """
        session = self._cached(session_id)
        if session is None:
            row, _, _ = await self._read(session_id)
            async with self._having(row.room):
                # Read again, now that no other server can change the session.
                found = await self._read(session_id)
                session = self._cached(session_id) or self._remember(self._restored(*found))
        if session.end is None and self._now() - session.used > self._rest:
            await self.end(session)
        return session

    async def _read(self, session_id: str) -> tuple[FairSessionRow, int, float]:
        found = await self._ledger.read(fair_store.session, session_id=session_id)
        if found is None:
            raise self._unknown(session_id)
        return found

    async def end(self, session: FairSession) -> None:
        """End a session and reveal the server's secret; does nothing if it has ended.

        Once begun, the same end is retried until it is committed, so all callers get the same
        signed statement. Raises LedgerError, UndecidedError.
        """
        if session.end is not None:
            return
        if session.ending is None:
            session.ending = asyncio.create_task(self._end(session), name=session.id)
        await self._ledger.decided(session.ending)

    async def _end(self, session: FairSession) -> None:
        secret, time_ms = session.server_seed.hex(), int(self._now() * 1000.0)

        def sign(drops: int) -> tuple[str, str]:
            end = Closing(session.id, drops, secret, time_ms).to_dict()
            return canonical(end).decode(), self.signer.sign(end).hex()

        try:
            async with self._having(session.room):
                row = FairEnd(session.id, session.room, sign)
                await self._ledger.keep(row)
            session.end, session.end_signature = msgspec.json.decode(row.end), row.end_signature
        finally:
            session.ending = None

    async def export(self, session: FairSession) -> bytes:
        """The session as JSON; its server seed is null until the end. Raises LedgerError."""
        self._persistence.runs.report([])
        found = await self._ledger.read(fair_store.exported, session_id=session.id)
        if found is None:
            raise self._unknown(session.id)
        head = TreeHead(
            found.size,
            merkle.root(found.size, _looked_up(found.nodes)).hex(),
            int(self._now() * 1000.0),
            found.log,
        )
        return msgspec.json.encode(self._exported(found, head, over=session.end is not None))

    async def head(self, since: int = 0) -> tuple[Signed, list[str]]:
        """The signed head of the log, and the proof that it has only grown since size `since`.

        Raises InvalidValueError if the log is smaller than `since`, LedgerError.
        """
        log, count, nodes = await self._ledger.read(fair_store.grown, since=since)
        if since > count:
            raise InvalidValueError(
                f"since {since} is more than the {count} receipts of the log", field="since"
            )
        lookup = _looked_up(nodes)
        head = TreeHead(count, merkle.root(count, lookup).hex(), int(self._now() * 1000.0), log)
        proof = merkle.consistency(since, count, lookup) if since else []
        return self._signed(head.to_dict()), [node.hex() for node in proof]

    def _exported(self, found: fair_store.Exported, head: TreeHead, *, over: bool) -> SessionExport:
        """The export of a session; the server's secret is included only if the end is durable."""
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
            keys=self._changes_since(self._key_of(row)) or msgspec.UNSET,
        )
        drops = [(each, _result(result)) for each, result in found.drops]
        return make_export(bare, drops, _looked_up(found.nodes))

    def _changes_since(self, key: str) -> list[KeyChange]:
        """The changes of the server's key after this one, the latest first."""
        changes = self.key_changes
        formers = [each.statement["former"] for each in changes]
        return changes[: formers.index(key) + 1] if key in formers else []

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
            key=self._key_of(row),
            signer=self.signer,
            used=used,
            client_seed=None if row.client_seed is None else bytes.fromhex(row.client_seed),
            drops=drops,
            end=None if row.end is None else msgspec.json.decode(row.end),
            end_signature=row.end_signature or "",
        )

    def _remember(self, session: FairSession) -> FairSession:
        session.lease = self._persistence.leases.book.of(session.room)
        self._sessions[session.id] = session
        while len(self._sessions) > _IN_MEMORY:
            oldest = next(iter(self._sessions.values()))
            if oldest.ending:
                break
            del self._sessions[oldest.id]
        return session

    def _unknown(self, session_id: str) -> UnknownSessionError:
        return UnknownSessionError(
            f"session {shorten(session_id)} is unknown, or was not joined here", field="session"
        )


def _looked_up(nodes: fair_store.Nodes) -> merkle.Lookup:
    return lambda level, number: nodes[level, number]


def _result(row: ResultRow | None) -> DropResult | None:
    if row is None:
        return None
    names = [name for name in DropResult.__struct_fields__ if name != "tick"]
    return DropResult(**{name: getattr(row, name) for name in names})
