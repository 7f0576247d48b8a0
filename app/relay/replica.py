"""A relay's side of one room: who watches it here, and what of the letters each of them is sent.

It knows nothing of the room but the latest letters. Who comes waits for a hello, which the room's
process sends for all who came in the same moment; then the letters go on to them as they are. Where
one is missing, everyone begins anew with the next hello. Decides; the hub sends.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import msgspec

from app.errors import RoomFullError
from app.live.broadcast.hub import Client, Hub
from app.protocol.messages import SEEDS, Hello, Pong, encode_event
from app.protocol.wire import WireMessage
from app.relay.letter import END, HELLO, Letter, decode

PATIENCE: Final = 3.0
"""s that somebody waits for a hello; then the room's own process is asked for more than letters."""

QUIET: Final = 5.0
"""s without a letter after which a hello is wished for, to hear whether anybody is there."""

GONE: Final = 10.0
"""s without a letter after which nobody is."""

_SAMPLES: Final = 64
"""Letters of which the quickest says how far the two clocks are apart."""


@dataclass(slots=True)
class Watcher:
    """Who watches here. `hand_over` is called when the room itself must be asked."""

    client: Client
    since: float
    hand_over: Callable[[], None]


class Replica:
    """One room as a relay hears of it.

    `wish` asks for letters, with a hello or without; `clock` is this process's, in s.
    """

    def __init__(
        self, room_id: str, hub: Hub, wish: Callable[[bool], None], clock: Callable[[], float]
    ) -> None:
        self.room_id = room_id
        self._hub = hub
        self._wish = wish
        self._clock = clock
        self._waiting: dict[int, Watcher] = {}
        self._greeted: dict[int, Watcher] = {}
        self._last: Letter | None = None  # None: the next hello is for everyone
        self._clocked: Letter | None = None  # the latest, in order or not
        self._run = ""
        self._heard = clock()
        self._offsets: deque[float] = deque(maxlen=_SAMPLES)

    @property
    def count(self) -> int:
        """Those who watch here, greeted or not."""
        return len(self._waiting) + len(self._greeted)

    def join(self, client: Client, hand_over: Callable[[], None]) -> None:
        """Let a client watch, from the next hello on; raises RoomFullError."""
        if self.count >= self._hub.max_clients:
            raise RoomFullError(
                f"room {self.room_id!r} already has {self._hub.max_clients} clients here"
            )
        if not self.count:
            self._last = None  # what was heard while nobody watched says nothing
        first = not self._waiting
        self._waiting[client.id] = Watcher(client, self._clock(), hand_over)
        if first:
            self._wish(True)

    def leave(self, client: Client) -> None:
        """Forget a client."""
        if self._greeted.pop(client.id, None) is not None:
            self._hub.leave(self.room_id, client)
        self._waiting.pop(client.id, None)

    def take(self, data: bytes) -> None:
        """Hear a letter; raises MalformedError for what is none."""
        letter = decode(data)
        self._heard = self._clock()
        self._offsets.append(self._heard - letter.now)
        before, self._last, self._clocked = self._last, letter, letter
        if letter.kind == END:
            self._hand_over([*self._waiting.values(), *self._greeted.values()])
        elif letter.kind == HELLO:
            self._greet(letter, everyone=before is None or not _follows(before, letter))
        elif before is None or not _follows(before, letter):
            self._last = None
            self._wish(True)
        else:
            self._hub.publish(self.room_id, SEEDS, letter.payload, None)

    def tend(self) -> None:
        """Once a second while somebody watches: go on wishing, and see who has waited too long."""
        now = self._clock()
        quiet = now - self._heard
        self._wish(bool(self._waiting) or self._last is None or quiet > QUIET)
        tired = [each for each in self._waiting.values() if now - each.since > PATIENCE]
        self._hand_over([*tired, *(self._greeted.values() if quiet > GONE else ())])

    def pong(self, t: float) -> Pong | None:
        """The answer to a ping, on this process's clock; None before anything was heard."""
        last = self._clocked
        if last is None:
            return None
        tick_time = last.tick_time + min(self._offsets)
        return Pong(t=t, tick=last.tick, tick_time=tick_time, server_time=self._clock())

    def _greet(self, letter: Letter, *, everyone: bool) -> None:
        hello = msgspec.json.decode(letter.payload, type=Hello)
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


def _follows(before: Letter, letter: Letter) -> bool:
    """Whether no letter is missing between the two."""
    return before.feed == letter.feed and before.number + 1 == letter.number
