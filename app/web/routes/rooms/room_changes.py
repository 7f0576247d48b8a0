"""What one client may change in a room whose balls touch each other, and how often."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Any

from app.errors import AppError, TokenError
from app.protocol import messages
from app.protocol.touching_messages import (
    Change,
    ClaimMessage,
    DragMessage,
    ReleaseMessage,
    WatchMessage,
)
from app.rooms.room import Room
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

    def watch(self, room: Room, message: WatchMessage) -> None:
        """Subscribe to diagnostics, or end that."""
        wanted = message.diagnostics
        self._server.rooms.broadcaster.watch_diagnostics(room, self._client, wanted)

    def take(self, room: Room, message: Change) -> "asyncio.Future[messages.Event | None]":
        """Give the room an input.

        Raises TokenError, RateLimitError, InvalidValueError, MissingBallError, BallLimitError,
        LedgerError.
        """
        room.check_changeable()
        if self._server.rooms.owned(room) and not self._claimed:
            raise TokenError(
                f"room {room.id!r} is changed by its creator: send `claim` with its token",
                field="type",
            )
        spend(self._bucket, time.monotonic(), "changes")
        if isinstance(message, ReleaseMessage):
            self._holding.discard(message.ball)  # even one that has gone is not held any more
        asked = self._server.rooms.change(room, message, client=self._client, ref=message.ref)
        if isinstance(message, DragMessage):
            self._holding.add(message.ball)
        return asked

    def let_go(self) -> None:
        """The client has gone; what it held falls."""
        for ball in sorted(self._holding):
            # A room that has gone too, or a ledger that is lost: the hand lapses by itself.
            with contextlib.suppress(AppError):
                room = self._server.rooms.find(self._room_id)
                self._server.rooms.change(room, ReleaseMessage(ball=ball))
        self._holding.clear()
