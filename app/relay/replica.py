"""A relay's side of one room: its spectators, and which of the feed's messages each is sent.

A replica knows nothing of the room except the latest messages of its feed. A new spectator waits
for a hello; the server sends one for all spectators that join at about the same time. From then on
the spectator is sent each message's payload unchanged. If a message is missing, all spectators are
sent the next hello. The replica decides, and the hub sends.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import msgspec

from plinko.app.errors import RoomFullError
from plinko.app.live.broadcast.hub import Client, Hub
from plinko.app.protocol.messages import SEEDS, Hello, Pong, encode_event
from plinko.app.protocol.wire import WireMessage
from plinko.app.relay.feed_messages import END, HELLO, FeedMessage, decode

PATIENCE: Final = 3.0
"""Seconds that a spectator waits for a hello before it is connected with the room's server."""

QUIET: Final = 5.0
"""Seconds without a message after which the relay asks for a hello, to find out whether the server
still answers."""

GONE: Final = 10.0
"""Seconds without a message after which all spectators are connected with the room's server."""

_SAMPLES: Final = 64
"""Number of the latest messages from which the difference of the two clocks is estimated: the
message with the shortest delay gives the best estimate."""


@dataclass(slots=True)
class Watcher:
    """A spectator. `hand_over` is called when its client must be connected with the server."""

    client: Client
    since: float
    hand_over: Callable[[], None]


class Replica:
    """One room on a relay.

    `request` asks the server for messages, with a hello (true) or without; `clock` is this
    process's monotonic clock, in s.
    """

    def __init__(
        self, room_id: str, hub: Hub, request: Callable[[bool], None], clock: Callable[[], float]
    ) -> None:
        self.room_id = room_id
        self._hub = hub
        self._request = request
        self._clock = clock
        self._waiting: dict[int, Watcher] = {}
        self._greeted: dict[int, Watcher] = {}
        self._last: FeedMessage | None = None  # None: one is missing, so the next hello is for all
        self._clocked: FeedMessage | None = None  # the latest message, even after a missing one
        self._run = ""
        self._heard = clock()
        self._offsets: deque[float] = deque(maxlen=_SAMPLES)

    @property
    def count(self) -> int:
        """The number of spectators here, also those that wait for a hello."""
        return len(self._waiting) + len(self._greeted)

    def join(self, client: Client, hand_over: Callable[[], None]) -> None:
        """Add a client, which is sent everything from the next hello on; raises RoomFullError."""
        if self.count >= self._hub.max_clients:
            raise RoomFullError(
                f"room {self.room_id!r} already has {self._hub.max_clients} clients here"
            )
        if not self.count:
            self._last = None  # the relay was not subscribed, so messages may be missing
        first = not self._waiting
        self._waiting[client.id] = Watcher(client, self._clock(), hand_over)
        if first:
            self._request(True)

    def leave(self, client: Client) -> None:
        if self._greeted.pop(client.id, None) is not None:
            self._hub.leave(self.room_id, client)
        self._waiting.pop(client.id, None)

    def take(self, data: bytes) -> None:
        """Handle a message from the bus; raises MalformedError."""
        message = decode(data)
        self._heard = self._clock()
        self._offsets.append(self._heard - message.now)
        before, self._last, self._clocked = self._last, message, message
        if message.kind == END:
            self._hand_over([*self._waiting.values(), *self._greeted.values()])
        elif message.kind == HELLO:
            self._greet(message, everyone=before is None or not _follows(before, message))
        elif before is None or not _follows(before, message):
            self._last = None
            self._request(True)
        else:
            self._hub.publish(self.room_id, SEEDS, message.payload, None)

    def tend(self) -> None:
        """Renew the request for messages, and hand over spectators that have waited too long.

        Called once a second while the replica has spectators.
        """
        now = self._clock()
        quiet = now - self._heard
        self._request(bool(self._waiting) or self._last is None or quiet > QUIET)
        tired = [each for each in self._waiting.values() if now - each.since > PATIENCE]
        self._hand_over([*tired, *(self._greeted.values() if quiet > GONE else ())])

    def pong(self, t: float) -> Pong | None:
        """The answer to a ping, on this process's clock; None before the first message."""
        last = self._clocked
        if last is None:
            return None
        tick_time = last.tick_time + min(self._offsets)
        return Pong(t=t, tick=last.tick, tick_time=tick_time, server_time=self._clock())

    def _greet(self, message: FeedMessage, *, everyone: bool) -> None:
        hello = msgspec.json.decode(message.payload, type=Hello)
        everyone = everyone or hello.run != self._run
        self._run = hello.run
        for watcher in list(self._greeted.values()) if everyone else ():
            self._send(hello, watcher.client)
        waiting, self._waiting = self._waiting, {}
        for number, watcher in waiting.items():
            self._greeted[number] = watcher
            self._hub.join(self.room_id, watcher.client)
            self._send(hello, watcher.client)

    def _send(self, hello: Hello, client: Client) -> None:
        time = hello.server_time + min(self._offsets)
        own = msgspec.structs.replace(hello, key=client.key, server_time=time)
        client.post(WireMessage.of_text(encode_event(own)))

    def _hand_over(self, watchers: list[Watcher]) -> None:
        for watcher in watchers:
            self.leave(watcher.client)
            watcher.hand_over()


def _follows(before: FeedMessage, message: FeedMessage) -> bool:
    """Whether no message is missing between these two."""
    return before.feed == message.feed and before.number + 1 == message.number
