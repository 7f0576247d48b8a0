"""The server's side of relays: publishes a room's stream `seeds` on the bus, once for all relays.

A feed is one more client of the room, whose connection is the bus. It exists while relays ask for
it. When a relay has a new spectator and asks for a hello, the room sends the feed another hello.
"""

import asyncio
import contextlib
import functools
import logging
import secrets
import time
from collections.abc import Callable, Iterator
from typing import Final

from plinko.app.errors import AppError, LeaseLostError, MalformedError
from plinko.app.live.broadcast.hub import Client, Mailbox
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.registry import Rooms
from plinko.app.protocol.messages import SEEDS
from plinko.app.protocol.wire import WireMessage
from plinko.app.relay.bus import Bus
from plinko.app.relay.feed_messages import (
    END,
    REQUESTS,
    FeedMessage,
    channel_of,
    decode_request,
    encode_request,
    kind_of,
    payload_of,
)

KEPT: Final = 3.0
"""Seconds for which a feed continues after a relay's last request; relays ask once a second."""

TOGETHER: Final = 0.05
"""Seconds by which a requested hello is delayed, so that one hello answers several requests."""

_log = logging.getLogger("plinko")


class Feed:
    """Publishes one room's messages; the room's hub uses it as a client's connection."""

    def __init__(self, bus: Bus, room_id: str, clock: Callable[[], float]) -> None:
        self.requested = clock()
        self.greets = False  # whether a hello is scheduled
        self.live: LiveRoom | None = None  # the room once it is found
        self.client: Client | None = None  # set while it watches the room
        self._bus = bus
        self._channel = channel_of(room_id)
        self._clock = clock
        self._name = secrets.token_bytes(8)
        self._number = 0

    def write(self, wire: bytes) -> bool:
        """Publish a message that the hub has framed for clients."""
        payload = payload_of(wire)
        self._send(kind_of(payload), payload)
        return True

    async def send(self, message: WireMessage) -> None:
        """As `write`: the interface of a connection allows waiting, but the bus needs none."""
        self.write(message.wire)

    def end(self) -> None:
        """Publish that this feed ends; relays then connect their spectators with the server."""
        self._send(END, b"")

    def _send(self, kind: int, payload: bytes) -> None:
        self._number += 1
        live = self.live
        tick, tick_time = (0, 0.0) if live is None else (live.room.world.tick, live.tick_time)
        times = (tick, tick_time, self._clock())
        message = FeedMessage(kind, self._name, self._number, *times, payload)
        self._bus.publish(self._channel, message.encode())


async def feed_relays(bus: Bus | None, rooms: Rooms, client_ids: Iterator[int]) -> None:
    """Run the bus and the feeds until cancelled; returns at once if there is no bus."""
    if bus is None:
        return

    # With several servers, all of them receive a relay's request, and only the server that has
    # the room answers it.
    def holds(room_id: str) -> bool:
        return rooms.stored.alone or rooms.is_open(room_id)

    feeds = Feeds(bus, rooms, new_client=client_ids.__next__, holds=holds)
    try:
        await bus.run()
    finally:
        feeds.close()


class Feeds:
    """The feeds of all rooms that relays ask for.

    `holds` returns whether this server has a room; `kept` is the time in s for which a feed
    continues after the last request.
    """

    def __init__(
        self,
        bus: Bus,
        rooms: Rooms,
        *,
        new_client: Callable[[], int],
        holds: Callable[[str], bool] = lambda _: True,
        clock: Callable[[], float] = time.monotonic,
        kept: float = KEPT,
    ) -> None:
        self._bus = bus
        self._kept = kept
        self._rooms = rooms
        self._new_client = new_client
        self._holds = holds
        self._clock = clock
        self._feeds: dict[str, Feed] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        bus.subscribe(REQUESTS, self._heard)

    @property
    def count(self) -> int:
        return len(self._feeds)

    def close(self) -> None:
        self._bus.unsubscribe(REQUESTS)
        for task in self._tasks:
            task.cancel()

    def _heard(self, data: bytes) -> None:
        try:
            room_id, hello = decode_request(data)
        except MalformedError as error:
            _log.warning("ignored an invalid request on the bus", extra={"error": str(error)})
            return
        if not self._holds(room_id):
            return
        feed = self._feeds.get(room_id)
        if feed is None:
            self._begin(room_id)
            return
        feed.requested = self._clock()
        if hello and not feed.greets:
            feed.greets = True
            greet = functools.partial(self._greet, room_id, feed)
            asyncio.get_running_loop().call_later(TOGETHER, greet)

    def _begin(self, room_id: str) -> None:
        feed = self._feeds[room_id] = Feed(self._bus, room_id, self._clock)
        task = asyncio.create_task(self._run(room_id, feed), name=f"feed of {room_id}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _run(self, room_id: str, feed: Feed) -> None:
        """Feed a room until no relay asks for it any more, or the room ends."""
        try:
            live = await self._rooms.seek(room_id)
            if live.room.stream_of(SEEDS) == SEEDS:
                await self._watch(live, feed)
            else:
                feed.end()
        except LeaseLostError:
            # The room has moved to another server. Ask that server, in the relays' name, to send
            # all spectators a hello before they miss a message.
            self._bus.publish(REQUESTS, encode_request(room_id, hello=True))
        except AppError:
            feed.end()
        finally:
            del self._feeds[room_id]

    async def _watch(self, live: LiveRoom, feed: Feed) -> None:
        # `write` always succeeds, so the mailbox for a slow client is never used.
        client = Client(self._new_client(), feed, Mailbox(1, 1), self._kept, stream=SEEDS)
        feed.live = live
        self._rooms.enter(live, client)
        feed.client = client
        writing = asyncio.create_task(client.run())
        try:
            while (left := feed.requested + self._kept - self._clock()) > 0 and not writing.done():
                await asyncio.wait([writing], timeout=left)
            if writing.done():
                writing.result()  # raises the error with which the room closed its clients
        finally:
            feed.client = None
            self._rooms.exit(live, client)
            writing.cancel()
            with contextlib.suppress(asyncio.CancelledError, AppError):
                await writing

    def _greet(self, room_id: str, feed: Feed) -> None:
        """Publish a hello, after the events that happened before it."""
        feed.greets = False
        if feed.client is None:
            return  # it is about to enter the room, which greets it like any client
        with contextlib.suppress(AppError):
            live = self._rooms.find(room_id)
            live.wake()
            live.audience.release()
            live.audience.greet(feed.client)
            live.tell_waiting(feed.client)
