"""Presence: the visitors of a room, who have given a name or colour, see a list of each other.

The list is short and sent at most once a second, and before a newcomer's first ball. Only visitors
and their audience receive it, and a room without them costs nothing. A player with several
connections, such as tabs of a browser, is one visitor.
"""

import asyncio
import time
from collections import Counter, OrderedDict
from collections.abc import Callable
from itertools import islice
from typing import Final

import msgspec

from plinko.app.live.broadcast.hub import Client
from plinko.app.protocol import messages
from plinko.app.protocol.visitors import Appearance, Visitor
from plinko.app.protocol.wire import WireMessage

MOST_NAMED: Final = 24
"""Visitors listed in one event: the last that came, changed their name or dropped a ball."""

_PAUSE: Final = 1.0  # s at least between two events of a room, but for newcomers' first balls

_SENDS: Final = 200.0
"""Most presence messages a second in a room: with more visitors, updates become rarer."""


class Company:
    """The visitors of one room, the longest idle first, numbered from 1."""

    def __init__(self) -> None:
        self.clients: dict[int, Client] = {}  # visitors and audience
        self._players: dict[int, str | int] = {}  # by client: its `who`, or else its own id
        self._connections: Counter[str | int] = Counter()  # by player
        self._visitors: OrderedDict[str | int, Visitor] = OrderedDict()  # by player
        self._numbers = 0
        self._listed = 0  # the last number when the state was last sent
        self._last_sent: messages.Presence | None = None  # the last state sent

    @property
    def pause(self) -> float:
        """Seconds at least between two updates."""
        return max(_PAUSE, len(self.clients) / _SENDS)

    @property
    def is_crowd(self) -> bool:
        """Whether the server sends updates less often, because it has many clients to send to."""
        return self.pause > _PAUSE

    def appear(self, client: Client, appearance: Appearance) -> int | msgspec.UnsetType:
        """Add a visitor, or change its name and colour; returns its number, unset for audience."""
        self.clients[client.id] = client
        player = client.id if appearance.who is None else appearance.who
        if appearance.audience or self._players.get(client.id) != player:
            self._stop_playing(client.id)
        if appearance.audience:
            return msgspec.UNSET
        if client.id not in self._players:
            self._players[client.id] = player
            self._connections[player] += 1
        known = self._visitors.get(player)
        if known is None:
            self._numbers += 1
        number = self._numbers if known is None else known.visitor
        self._visitors[player] = Visitor(number, appearance.name, appearance.colour)
        self._visitors.move_to_end(player)
        return number

    def _stop_playing(self, client_id: int) -> None:
        player = self._players.pop(client_id, None)
        if player is None:
            return
        self._connections[player] -= 1
        if not self._connections[player]:
            del self._connections[player], self._visitors[player]

    def leave(self, client_id: int) -> bool:
        self._stop_playing(client_id)
        return self.clients.pop(client_id, None) is not None

    def act(self, client_id: int | None) -> int | None:
        """Note that a client has dropped a ball; returns its number if it is a visitor."""
        player = None if client_id is None else self._players.get(client_id)
        if player is None:
            return None
        self._visitors.move_to_end(player)
        return self._visitors[player].visitor

    def is_new(self, visitor: int) -> bool:
        """Whether this visitor came after the state was last sent."""
        return visitor > self._listed

    def state(self) -> messages.Presence:
        """The number of visitors, and the most recently active ones in the order of numbers."""
        last = islice(reversed(self._visitors.values()), MOST_NAMED)
        named = sorted(last, key=lambda visitor: visitor.visitor)
        return messages.Presence(here=len(self._visitors), visitors=named)

    def news(self) -> messages.Presence | None:
        """The state, unless it equals the last one sent."""
        state, self._listed = self.state(), self._numbers
        if state == self._last_sent:
            return None
        self._last_sent = state
        return state


def _later(seconds: float, call: Callable[[], None]) -> None:
    asyncio.get_running_loop().call_later(seconds, call)


class Presence:
    """The visitors of all rooms. `later` calls a function after some seconds."""

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        later: Callable[[float, Callable[[], None]], None] = _later,
    ) -> None:
        self._clock = clock
        self._later = later
        self._companies: dict[str, Company] = {}
        self._sent_at: dict[str, float] = {}
        self._waiting: set[str] = set()  # rooms with an update scheduled

    def appear(self, room_id: str, client: Client, appearance: Appearance) -> messages.Presence:
        """Make a client a visitor; returns its answer, and schedules an update for the others."""
        company = self._companies.setdefault(room_id, Company())
        number = company.appear(client, appearance)
        self._send_soon(room_id)
        return msgspec.structs.replace(company.state(), you=number)

    def leave(self, room_id: str, client_id: int) -> None:
        company = self._companies.get(room_id)
        if company is None or not company.leave(client_id):
            return
        if company.clients:
            self._send_soon(room_id)
        else:
            del self._companies[room_id]
            self._sent_at.pop(room_id, None)

    def signed(self, room_id: str, client_id: int | None, event: messages.Event) -> messages.Event:
        """Add the visitor's number to an `accepted` event; returns other events unchanged."""
        company = self._companies.get(room_id)
        if company is None or not isinstance(event, messages.Accepted):
            return event
        visitor = company.act(client_id)
        if visitor is None:
            return event
        if company.is_new(visitor) and not company.is_crowd:
            self._send(room_id)
        else:
            self._send_soon(room_id)
        return msgspec.structs.replace(event, visitor=visitor)

    def _send_soon(self, room_id: str) -> None:
        """Schedule one update of a room's visitors for all changes until then."""
        if room_id in self._waiting:
            return
        self._waiting.add(room_id)
        sent_at = self._sent_at.get(room_id)
        due = 0.0 if sent_at is None else sent_at + self._companies[room_id].pause
        self._later(max(0.0, due - self._clock()), lambda: self._send(room_id))

    def _send(self, room_id: str) -> None:
        self._waiting.discard(room_id)
        company = self._companies.get(room_id)
        news = None if company is None else company.news()
        if company is None or news is None:
            return
        self._sent_at[room_id] = self._clock()
        message = WireMessage.of_text(messages.encode_event(news))
        for client in list(company.clients.values()):
            client.post(message)
