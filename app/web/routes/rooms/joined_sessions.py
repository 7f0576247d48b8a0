"""The fair sessions that one connection has begun or joined, and may drop in."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from plinko.app.errors import InvalidValueError, UnknownSessionError
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.protocol import messages
from plinko.app.protocol.client_messages import (
    EndMessage,
    OpenMessage,
    SessionMessage,
    SessionRequest,
)
from plinko.app.rooms.room import Room
from plinko.app.web.services import Services
from plinko.engine.errors import shorten


class JoinedSessions:
    """Carries out one connection's messages about sessions; a session's token joins it."""

    def __init__(self, server: Services) -> None:
        self._fair = server.fair
        self._tokens = server.session_tokens
        self._joined: set[str] = set()
        self._turns: list[tuple[str, bool, asyncio.Event]] = []

    @asynccontextmanager
    async def in_turn(self, session_id: str | None, *, alone: bool) -> AsyncIterator[None]:
        """Carry out a message about a session after earlier ones, whose commits take time.

        Drops are committed together. Messages that join, open or end the session are carried out
        `alone`: an end waits for the drops sent before it, and a drop for the opening.
        """
        if session_id is None:
            yield
            return
        before = [
            done
            for other, is_alone, done in self._turns
            if other == session_id and alone | is_alone
        ]
        turn = (session_id, alone, asyncio.Event())
        self._turns.append(turn)
        try:
            for done in before:
                await done.wait()
            yield
        finally:
            self._turns.remove(turn)
            turn[2].set()

    async def take(self, room: Room, message: SessionRequest) -> messages.Event:
        """Carry out a message about a session, and return the answer.

        Raises InvalidValueError, UnknownSessionError, SessionStateError, TokenError, LedgerError.
        """
        match message:
            case SessionMessage():
                return await self._begin_or_join(room, message)
            case OpenMessage():
                session = self.of(message.session)
                await self._fair.open(session, message.seed)
                return session.state(ref=message.ref)
            case EndMessage():
                session = self.of(message.session)
                await self._fair.end(session)
                return session.ended(ref=message.ref)

    def of(self, session_id: str) -> FairSession:
        """The session of this id; raises UnknownSessionError if it was not joined here."""
        if session_id not in self._joined:
            raise UnknownSessionError(
                f"session {shorten(session_id)} was not joined on this connection: send `session` "
                "with its id and token",
                field="session",
            )
        return self._fair.joined(session_id)

    async def _begin_or_join(self, room: Room, message: SessionMessage) -> messages.SessionState:
        if (message.session is None) == (message.commitment is None):
            raise InvalidValueError(
                "give either `commitment` to begin a session, or `session` and `token` to join one",
                field="commitment",
            )
        if message.session is None:
            session = await self._fair.begin(room, message.commitment)
            token = self._tokens.of(session.id)
        else:
            self._tokens.check_shown(message.session, message.token)
            session, token = await self._fair.find(message.session), None
        self._joined.add(session.id)
        return session.state(token=token, ref=message.ref)
