"""What one client may change in a room whose balls touch each other, and how often."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Any

import msgspec

from app.errors import AppError, InvalidValueError, TokenError
from app.protocol import messages
from app.protocol.touching_messages import (
    Change,
    ClaimMessage,
    DragMessage,
    ReleaseMessage,
    WatchMessage,
)
from app.rooms.kinds import AnyRoom
from app.rooms.touching.room import ArenaRoom
from app.web.limits import TokenBucket, spend
from app.web.services import Services

Failed = Callable[["asyncio.Future[Any]"], None]


class Changes:
    """The changes that come over one connection.

    A room of nobody is everybody's; one that has a creator is changed by whoever claimed it with
    its token. A client that goes away lets go of the balls it held.
    """

    def __init__(self, server: Services, room_id: str, client: int) -> None:
        self._server = server
        self._room_id = room_id
        self._client = client
        self._claimed = False
        self._holding: set[int] = set()
        rate = server.settings.change_rate
        self._bucket = TokenBucket(rate, 2 * rate, time.monotonic())

    def claim(self, message: ClaimMessage) -> messages.Claimed:
        """Check the room's token; raises TokenError."""
        self._server.tokens.check(self._room_id, f"Bearer {message.token}")
        self._claimed = True
        return messages.Claimed(ref=message.ref)

    def watch(self, room: AnyRoom, message: WatchMessage) -> None:
        """Subscribe to diagnostics, or end that."""
        self._server.rooms.teller.watch(self._touching(room), self._client, message.diagnostics)

    def take(self, room: AnyRoom, message: Change) -> "asyncio.Future[messages.Event | None]":
        """Give the room an input.

        Raises TokenError, RateLimitError, InvalidValueError, MissingBallError, BallLimitError,
        LedgerError.
        """
        arena = self._touching(room)
        if self._server.rooms.owned(arena) and not self._claimed:
            raise TokenError(
                f"room {arena.id!r} is changed by its creator: send `claim` with its token",
                field="type",
            )
        spend(self._bucket, time.monotonic(), "changes")
        data = msgspec.to_builtins(message)
        ref = data.pop("ref")
        asked = self._server.rooms.change(arena, data, client=self._client, ref=ref)
        if isinstance(message, DragMessage):
            self._holding.add(message.ball)
        elif isinstance(message, ReleaseMessage):
            self._holding.discard(message.ball)
        return asked

    def let_go(self) -> None:
        """The client has gone; what it held falls."""
        for ball in sorted(self._holding):
            # A room that has gone too, or a ledger that is lost: the hand lapses by itself.
            with contextlib.suppress(AppError):
                room = self._touching(self._server.rooms.find(self._room_id))
                self._server.rooms.change(room, {"type": "release", "ball": ball})
        self._holding.clear()

    def _touching(self, room: AnyRoom) -> ArenaRoom:
        if not isinstance(room, ArenaRoom):
            raise InvalidValueError(
                f"room {room.id!r} is one of independent balls, which cannot be changed; open one "
                "with mode `interacting`, or a scene",
                field="type",
            )
        return room
