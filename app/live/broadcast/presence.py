"""Who is at each table: visitors who said so are told of each other, seldom and never all of them.

A client that says nothing of itself hears nothing of this, and a room without any costs nothing.
"""

import asyncio
import time
from collections import OrderedDict
from collections.abc import Callable
from itertools import islice
from typing import Final

import msgspec

from app.live.broadcast.hub import Client
from app.protocol import messages
from app.protocol.visitors import Visitor
from app.protocol.wire import WireMessage

MOST_NAMED: Final = 24
"""Visitors that one event names: those who last came, changed or dropped a ball."""

_PAUSE: Final = 1.0  # s at least between two events of a room

_SENDS: Final = 200.0
"""Messages a second that a room sends of this at most: where there are more visitors, they hear of
each other less often."""


class Company:
    """The visitors of one room, the longest quiet first. Numbers begin at 1 in each company."""

    def __init__(self) -> None:
        self.clients: dict[int, Client] = {}
        self._visitors: OrderedDict[int, Visitor] = OrderedDict()  # by client
        self._numbers = 0
        self._told: messages.Presence | None = None

    def appear(self, client: Client, name: str | None, colour: str | None) -> Visitor:
        """Take in a client, or what it changes of itself."""
        known = self._visitors.get(client.id)
        if known is None:
            self._numbers += 1
        number = self._numbers if known is None else known.visitor
        self.clients[client.id] = client
        self._visitors[client.id] = Visitor(number, name, colour)
        self._visitors.move_to_end(client.id)
        return self._visitors[client.id]

    def leave(self, client_id: int) -> bool:
        self.clients.pop(client_id, None)
        return self._visitors.pop(client_id, None) is not None

    def act(self, client_id: int | None) -> int | None:
        """The number of the visitor who has just dropped a ball, if it is one."""
        if client_id is None or client_id not in self._visitors:
            return None
        self._visitors.move_to_end(client_id)
        return self._visitors[client_id].visitor

    def state(self) -> messages.Presence:
        """How many are here and who was last heard of, by their numbers."""
        last = islice(reversed(self._visitors.values()), MOST_NAMED)
        named = sorted(last, key=lambda visitor: visitor.visitor)
        return messages.Presence(here=len(self._visitors), visitors=named)

    def news(self) -> messages.Presence | None:
        """The state, unless it is the one that was told last."""
        state = self.state()
        if state == self._told:
            return None
        self._told = state
        return state


def _later(seconds: float, call: Callable[[], None]) -> None:
    asyncio.get_running_loop().call_later(seconds, call)


class Presence:
    """The company of every room that has one. `later` calls something after so many seconds."""

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        later: Callable[[float, Callable[[], None]], None] = _later,
    ) -> None:
        self._clock = clock
        self._later = later
        self._companies: dict[str, Company] = {}
        self._told_at: dict[str, float] = {}
        self._waiting: set[str] = set()  # rooms whose visitors will be told

    def appear(
        self, room_id: str, client: Client, name: str | None, colour: str | None
    ) -> messages.Presence:
        """A client is seen in a room from now on; what it is told at once, the others soon."""
        company = self._companies.setdefault(room_id, Company())
        visitor = company.appear(client, name, colour)
        self._tell_soon(room_id)
        return msgspec.structs.replace(company.state(), you=visitor.visitor)

    def leave(self, room_id: str, client_id: int) -> None:
        company = self._companies.get(room_id)
        if company is None or not company.leave(client_id):
            return
        if company.clients:
            self._tell_soon(room_id)
        else:
            del self._companies[room_id]
            self._told_at.pop(room_id, None)

    def signed(self, room_id: str, client_id: int | None, event: messages.Event) -> messages.Event:
        """An acceptance with the number of the visitor whose ball it is; all else as it is."""
        company = self._companies.get(room_id)
        if company is None or not isinstance(event, messages.Accepted):
            return event
        visitor = company.act(client_id)
        if visitor is None:
            return event
        self._tell_soon(room_id)
        return msgspec.structs.replace(event, visitor=visitor)

    def _tell_soon(self, room_id: str) -> None:
        """Have all visitors of a room told what is new, once for all that happens until then."""
        if room_id in self._waiting:
            return
        self._waiting.add(room_id)
        pause = max(_PAUSE, len(self._companies[room_id].clients) / _SENDS)
        told_at = self._told_at.get(room_id)
        rest = 0.0 if told_at is None else max(0.0, told_at + pause - self._clock())
        self._later(rest, lambda: self._tell(room_id))

    def _tell(self, room_id: str) -> None:
        self._waiting.discard(room_id)
        company = self._companies.get(room_id)
        news = None if company is None else company.news()
        if company is None or news is None:
            return
        self._told_at[room_id] = self._clock()
        message = WireMessage.of_text(messages.encode_event(news))
        for client in list(company.clients.values()):
            client.post(message)
