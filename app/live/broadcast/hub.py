"""The clients of each room, and how messages reach them without a slow client delaying others.

Events and paths are reliable: each client gets them in order, up to a bound of unread ones.
Snapshots are lossy: a newer one replaces one that has not been sent yet.

The hub writes directly to a connection whose buffer is empty, the same bytes for all clients. If a
buffer is not empty, the messages go to the client's own mailbox, and its own task sends them. If
the mailbox overflows, or one write takes longer than the grace period, the hub closes the
connection of this client as too slow.
"""

import asyncio
from collections import deque
from dataclasses import dataclass
from typing import Protocol

from plinko.app.errors import AppError, RoomFullError, SlowClientError
from plinko.app.protocol.wire import WireMessage


class Connection(Protocol):
    """The connection of a client."""

    def write(self, wire: bytes) -> bool:
        """Write these bytes, or return False if earlier ones still wait in the buffer."""

    async def send(self, message: WireMessage) -> None:
        """Wait until the buffer is empty, and write a message."""


@dataclass(slots=True)
class Traffic:
    """Totals of the traffic to all clients; they only grow."""

    frames: int = 0
    bytes: int = 0  # payload
    skipped: int = 0  # snapshots replaced by newer ones
    too_slow: int = 0  # clients closed as too slow


class Mailbox:
    """The messages that wait for one client: a bounded queue of events, and a snapshot. Pure."""

    def __init__(self, max_events: int, max_bytes: int) -> None:
        self.max_events = max_events
        self.max_bytes = max_bytes
        self.replaced = 0  # snapshots replaced by newer ones
        self._events: deque[WireMessage] = deque()
        self._size = 0
        self._snapshot: WireMessage | None = None

    def post(self, event: WireMessage) -> None:
        """Queue an event; raises SlowClientError when the queue is full."""
        if len(self._events) >= self.max_events or self._size + len(event.payload) > self.max_bytes:
            raise SlowClientError(
                f"{len(self._events)} event frames of {self._size} bytes wait unread"
            )
        self._events.append(event)
        self._size += len(event.payload)

    def show(self, snapshot: WireMessage) -> None:
        """Keep a snapshot in place of the previous one."""
        if self._snapshot is not None:
            self.replaced += 1
        self._snapshot = snapshot

    def take(self) -> WireMessage | None:
        """The next message to send. Events go first, so that no snapshot is ahead of them."""
        if self._events:
            event = self._events.popleft()
            self._size -= len(event.payload)
            return event
        snapshot, self._snapshot = self._snapshot, None
        return snapshot


class Client:
    """A client of a room: written to directly while it keeps up, otherwise through a mailbox."""

    def __init__(
        self,
        client_id: int,
        connection: Connection,
        mailbox: Mailbox,
        grace: float,
        *,
        stream: str = "snapshots",
        key: str = "",
        traffic: Traffic | None = None,
    ) -> None:
        self.id = client_id
        self.stream = stream
        self.key = key  # identifies it after a reconnect
        self.greeted = 0  # number of the room's last event before its latest hello
        self.mailbox = mailbox
        self._connection = connection
        self._grace = grace
        self._traffic = traffic or Traffic()
        self._keeps_up = True  # the mailbox is empty, and its task is not sending
        self._wake = asyncio.Event()
        self._writing: asyncio.Timeout | None = None
        self._failure: AppError | None = None
        self._end: AppError | None = None

    def post(self, event: WireMessage) -> None:
        """Write an event or queue it; a client whose queue is full will be closed."""
        if self._keeps_up and self._connection.write(event.wire):
            self._count(event)
            return
        try:
            self.mailbox.post(event)
        except SlowClientError as error:
            self.fail(error)
        self._keeps_up = False
        self._wake.set()

    def show(self, snapshot: WireMessage) -> None:
        """Write a snapshot, or keep it in the mailbox."""
        if self._keeps_up and self._connection.write(snapshot.wire):
            self._count(snapshot)
            return
        replaced = self.mailbox.replaced
        self.mailbox.show(snapshot)
        self._traffic.skipped += self.mailbox.replaced - replaced
        self._keeps_up = False
        self._wake.set()

    def write(self, wire: bytes) -> bool:
        """Write the bytes of several messages; returns False if the client does not keep up."""
        return self._keeps_up and self._connection.write(wire)

    def fail(self, error: AppError) -> None:
        """Make `run` raise this error at once, even while it waits for the client to read."""
        self._failure = self._failure or error
        self._keeps_up = False
        if self._writing is not None and not self._writing.expired():
            self._writing.reschedule(asyncio.get_running_loop().time())
        self._wake.set()

    def end(self, error: AppError) -> None:
        """Make `run` raise this error after it has sent the waiting messages."""
        self._end = self._end or error
        self._wake.set()

    async def run(self) -> None:
        """Send the mailbox's messages until `fail` or `end` is called, and raise that error.

        Raises SlowClientError if the client does not read.
        """
        while True:
            while self._failure is None and (message := self.mailbox.take()) is not None:
                await self._write_one(message)
            if (reason := self._failure or self._end) is not None:
                self._traffic.too_slow += isinstance(reason, SlowClientError)
                raise reason
            self._keeps_up = True
            self._wake.clear()
            await self._wake.wait()

    async def _write_one(self, message: WireMessage) -> None:
        try:
            async with asyncio.timeout(self._grace) as self._writing:
                await self._connection.send(message)
        except TimeoutError:
            self._failure = self._failure or SlowClientError(
                f"the client read nothing for {self._grace:g} seconds"
            )
        else:
            self._count(message)
        finally:
            self._writing = None

    def _count(self, message: WireMessage) -> None:
        self._traffic.frames += 1
        self._traffic.bytes += len(message.payload)


class Hub:
    """The clients of all rooms, by stream. Sending never waits."""

    def __init__(self, max_clients: int) -> None:
        self.max_clients = max_clients
        self.traffic = Traffic()
        self._rooms: dict[str, dict[str, dict[int, Client]]] = {}

    def join(self, room_id: str, client: Client) -> None:
        """Add a client to a room; raises RoomFullError."""
        if self.count(room_id) >= self.max_clients:
            raise RoomFullError(f"room {room_id!r} already has {self.max_clients} clients")
        streams = self._rooms.setdefault(room_id, {})
        streams.setdefault(client.stream, {})[client.id] = client

    def leave(self, room_id: str, client: Client) -> None:
        streams = self._rooms.get(room_id, {})
        clients = streams.get(client.stream, {})
        clients.pop(client.id, None)
        if not clients:
            streams.pop(client.stream, None)
        if not streams:
            self._rooms.pop(room_id, None)

    def count(self, room_id: str, stream: str | None = None) -> int:
        """The number of clients of a room, or of one of its streams."""
        streams = self._rooms.get(room_id, {})
        if stream is not None:
            return len(streams.get(stream, ()))
        return sum(map(len, streams.values()))

    @property
    def total(self) -> int:
        return sum(map(self.count, self._rooms))

    def clients(self, room_id: str) -> list[Client]:
        streams = self._rooms.get(room_id, {}).values()
        return [client for clients in streams for client in clients.values()]

    def announce(
        self,
        room_id: str,
        stream: str,
        event: bytes,
        requester: int | None = None,
        own: bytes = b"",
    ) -> None:
        """Send an event to all clients of a stream, but `own` to the client `requester`."""
        message = WireMessage.of_text(event)
        for client in self._rooms.get(room_id, {}).get(stream, {}).values():
            client.post(message if client.id != requester else WireMessage.of_text(own))

    def post(self, room_id: str, stream: str, payload: bytes) -> None:
        """Send a binary message, as reliably as an event, to all clients of a stream."""
        message = WireMessage.of_bytes(payload)
        for client in self._rooms.get(room_id, {}).get(stream, {}).values():
            client.post(message)

    def publish(
        self, room_id: str, stream: str, events: bytes | None, snapshot: bytes | None
    ) -> None:
        """Send a tick's events and snapshot to all clients of a stream, the same bytes to all."""
        messages = [WireMessage.of_text(events)] if events is not None else []
        if snapshot is not None:
            messages.append(WireMessage.of_bytes(snapshot))
        wire = b"".join(message.wire for message in messages)
        size = sum(len(message.payload) for message in messages)
        written = 0
        for client in self._rooms.get(room_id, {}).get(stream, {}).values():
            if client.write(wire):
                written += 1
                continue
            for message in messages:
                if message.text:
                    client.post(message)
                else:
                    client.show(message)
        self.traffic.frames += written * len(messages)
        self.traffic.bytes += written * size

    def close(self, room_id: str, error: AppError) -> None:
        """Close every connection to the room with this error, after the waiting messages."""
        for client in self.clients(room_id):
            client.end(error)

    def cut(self, room_id: str, error: AppError) -> None:
        """Close every connection to the room with this error, at once."""
        for client in self.clients(room_id):
            client.fail(error)
