"""What one client may change in a room whose balls touch each other, and how often."""

import contextlib
import time

from app.errors import AppError, InvalidValueError, MissingBallError, TokenError
from app.live.broadcast.audience import Player
from app.live.broadcast.hub import Client
from app.live.live_room import LiveRoom
from app.protocol import messages
from app.protocol.touching_messages import (
    Change,
    ClaimMessage,
    DragMessage,
    ReleaseMessage,
    WatchMessage,
)
from app.web.limits import TokenBucket, spend
from app.web.services import Services

CHANGE_RATE = 40.0  # changes a second from one client of a room whose balls touch each other


class Changes:
    """The changes that come over one connection.

    A room of nobody is everybody's; one that has a creator is changed by whoever claimed it with
    its token. A client that goes away lets go of the balls it held.
    """

    def __init__(self, server: Services, live: LiveRoom, client: Client) -> None:
        self._server = server
        self._live = live
        self._client = client
        self._claimed = False
        self._holding: set[int] = set()
        self._bucket = TokenBucket(CHANGE_RATE, 2 * CHANGE_RATE, time.monotonic())

    def claim(self, message: ClaimMessage) -> messages.Claimed:
        """Check the room's token; raises TokenError."""
        self._server.tokens.check(self._live.id, f"Bearer {message.token}")
        self._claimed = True
        return messages.Claimed(ref=message.ref)

    def check_owner(self, what: str) -> None:
        """Raise TokenError in an owned room that was not claimed; `what` its owner alone does."""
        if self._live.owned and not self._claimed:
            raise TokenError(
                f"room {self._live.id!r} has an owner, by whom alone {what}: send `claim` with "
                "its token",
                field="type",
            )

    def watch(self, message: WatchMessage) -> None:
        """Subscribe to diagnostics, or end that."""
        self._live.audience.watch_diagnostics(self._client.id, message.diagnostics)

    async def take(self, message: Change) -> messages.Event | None:
        """Give the room an input; returns the first event that came of it.

        Raises TokenError, RateLimitError, InvalidValueError, MissingBallError, BallLimitError,
        LedgerError.
        """
        live = self._live
        live.room.check_changeable()
        self.check_owner("it is changed")
        spend(self._bucket, time.monotonic(), "changes")
        if isinstance(message, ReleaseMessage):
            self._holding.discard(message.ball)  # even one that has gone is not held any more
        player = Player(client=self._client.id, ref=message.ref)
        if not isinstance(message, DragMessage):
            return await live.change(message, player)
        self._holding.add(message.ball)
        try:
            return await live.change(message, player)
        except (InvalidValueError, MissingBallError):
            self._holding.discard(message.ball)
            raise

    async def let_go(self) -> None:
        """The client has gone; what it held falls."""
        for ball in sorted(self._holding):
            # A room that has gone too, or a ledger that is lost: the hand lapses by itself.
            with contextlib.suppress(AppError):
                await self._live.change(ReleaseMessage(ball=ball))
        self._holding.clear()
