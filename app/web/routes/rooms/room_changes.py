"""One connection's changes to a room of touching balls: checks owner and rate, tracks grabs."""

import contextlib
import time

from plinko.app.errors import AppError, InvalidValueError, MissingBallError, TokenError
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.broadcast.hub import Client
from plinko.app.live.live_room import LiveRoom
from plinko.app.protocol import messages
from plinko.app.protocol.touching_messages import (
    Change,
    ClaimMessage,
    DragMessage,
    ReleaseMessage,
    WatchMessage,
)
from plinko.app.web.limits import TokenBucket, spend
from plinko.app.web.services import Services

CHANGE_RATE = 40.0  # changes a second from one client in a room of touching balls


class Changes:
    """The changes that one connection makes.

    Any client may change a room without an owner. A room with an owner accepts changes only from
    connections that have claimed it with its token. When a client leaves, the balls that it has
    grabbed are released.
    """

    def __init__(self, server: Services, live: LiveRoom, client: Client) -> None:
        self._server = server
        self._live = live
        self._client = client
        self._claimed = False
        self._grabbed: set[int] = set()
        self._bucket = TokenBucket(CHANGE_RATE, 2 * CHANGE_RATE, time.monotonic())

    def claim(self, message: ClaimMessage) -> messages.Claimed:
        """Check the room's token; raises TokenError."""
        self._server.tokens.check(self._live.id, f"Bearer {message.token}")
        self._claimed = True
        return messages.Claimed(ref=message.ref)

    def check_owner(self, what: str) -> None:
        """Raise TokenError if the room has an owner and this connection has not claimed it.

        `what` names what only the owner may do, for the message: 'change it'.
        """
        if self._live.owned and not self._claimed:
            raise TokenError(
                f"room {self._live.id!r} has an owner, and only the owner may {what}; send "
                "`claim` with the room's token",
                field="type",
            )

    def watch(self, message: WatchMessage) -> None:
        """Subscribe to diagnostics, or unsubscribe."""
        self._live.audience.watch_diagnostics(self._client.id, message.diagnostics)

    async def take(self, message: Change) -> messages.Event | None:
        """Give the room an input, and return the first event that it causes.

        Raises TokenError, RateLimitError, InvalidValueError, MissingBallError, BallLimitError,
        LedgerError.
        """
        live = self._live
        live.room.check_changeable()
        self.check_owner("change it")
        spend(self._bucket, time.monotonic(), "changes")
        if isinstance(message, ReleaseMessage):
            self._grabbed.discard(message.ball)  # even if the ball is gone and `change` raises
        player = Player(client=self._client.id, ref=message.ref)
        if not isinstance(message, DragMessage):
            return await live.change(message, player)
        self._grabbed.add(message.ball)
        try:
            return await live.change(message, player)
        except (InvalidValueError, MissingBallError):
            self._grabbed.discard(message.ball)
            raise

    async def release_all(self) -> None:
        """Release the balls that the client, which has left, had grabbed."""
        for ball in sorted(self._grabbed):
            # If the room is closed or the ledger fails, the room releases the ball after a while.
            with contextlib.suppress(AppError):
                await self._live.change(ReleaseMessage(ball=ball))
        self._grabbed.clear()
