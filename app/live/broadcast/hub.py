"""Who watches which room, and how what happens there reaches each client.

Two ways to a client. Events are reliable: in order, up to a bound. Snapshots are lossy: one slot,
and a newer one takes the place of the older. A client whose connection has room is written to at
once, the same bytes for all. One that does not read falls back on its own mailbox and writer, so
that it stops only itself. When a write takes longer than the grace period, or the mailbox
overflows, the client is too slow and is closed with that reason.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from app.errors import AppError, RoomFullError, SlowClientError
from app.protocol.wire import WireMessage


class Connection(Protocol):
    """A client's connection, as the hub needs it."""

    def write(self, wire: bytes) -> bool:
        """Send these bytes now, or return False when that would only pile them up."""

    async def send(self, message: WireMessage) -> None:
        """Send a message as soon as there is room for it."""


@dataclass(slots=True)
class Traffic:
    """What all clients together were sent; counts only go up."""

    frames: int = 0
    bytes: int = 0  # payload
    skipped: int = 0  # snapshots that a newer one overtook
    too_slow: int = 0  # clients closed for not reading


class Mailbox:
    """What waits for one client, pure: bounded events in order, and the latest snapshot.

    In a stream in which each snapshot adds to the one before, `keyframe` makes one that stands for
    all that waited.
    """

    def __init__(
        self, max_events: int, max_bytes: int, keyframe: Callable[[], WireMessage] | None = None
    ) -> None:
        self.max_events = max_events
        self.max_bytes = max_bytes
        self.replaced = 0  # snapshots that a newer one overtook
        self._keyframe = keyframe
        self._events: deque[WireMessage] = deque()
        self._size = 0
        self._snapshot: WireMessage | None = None
        self._needs_keyframe = False

    def post(self, event: WireMessage) -> None:
        """Queue an event; raises SlowClientError when the queue is full."""
        if len(self._events) >= self.max_events or self._size + len(event.payload) > self.max_bytes:
            raise SlowClientError(
                f"{len(self._events)} event frames of {self._size} bytes wait unread"
            )
        self._events.append(event)
        self._size += len(event.payload)

    def show(self, snapshot: WireMessage) -> None:
        """Put a snapshot in the slot; the one that was there is gone."""
        if self._snapshot is not None:
            self.replaced += 1
            self._needs_keyframe = self._keyframe is not None
        self._snapshot = snapshot

    def take(self) -> WireMessage | None:
        """The next message to send: events first, so that a snapshot never runs ahead of them."""
        if self._events:
            event = self._events.popleft()
            self._size -= len(event.payload)
            return event
        snapshot, self._snapshot = self._snapshot, None
        if self._needs_keyframe and self._keyframe is not None:
            self._needs_keyframe = False
            return self._keyframe()
        return snapshot


class Client:
    """One who watches: written to directly while it keeps up, through its mailbox while not."""

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
        self.key = key  # by which it is known when it comes back
        self.greeted = 0  # events announced before its latest hello
        self.mailbox = mailbox
        self._connection = connection
        self._grace = grace
        self._traffic = traffic or Traffic()
        self._keeps_up = True  # nothing waits in the mailbox and nothing is being sent from it
        self._wake = asyncio.Event()
        self._writing: asyncio.Timeout | None = None
        self._failure: AppError | None = None
        self._end: AppError | None = None

    def post(self, event: WireMessage) -> None:
        """Send an event, or queue it; a client whose queue is full is on its way out."""
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
        """Send a snapshot, or offer it for when there is room."""
        if self._keeps_up and self._connection.write(snapshot.wire):
            self._count(snapshot)
            return
        replaced = self.mailbox.replaced
        self.mailbox.show(snapshot)
        self._traffic.skipped += self.mailbox.replaced - replaced
        self._keeps_up = False
        self._wake.set()

    def write(self, wire: bytes) -> bool:
        """Send several messages at once if the client keeps up; else False, and nothing is done."""
        return self._keeps_up and self._connection.write(wire)

    def fail(self, error: AppError) -> None:
        """End the connection with this reason: `run` raises it, even out of a blocked send."""
        self._failure = self._failure or error
        self._keeps_up = False
        if self._writing is not None and not self._writing.expired():
            self._writing.reschedule(asyncio.get_running_loop().time())
        self._wake.set()

    def end(self, error: AppError) -> None:
        """End the connection with this reason once it was sent what waits."""
        self._end = self._end or error
        self._wake.set()

    async def run(self) -> None:
        """Send what waits, for ever; raises SlowClientError when the client does not read."""
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
                f"nothing was read for {self._grace:g} seconds"
            )
        else:
            self._count(message)
        finally:
            self._writing = None

    def _count(self, message: WireMessage) -> None:
        self._traffic.frames += 1
        self._traffic.bytes += len(message.payload)


class Hub:
    """The clients of every room, by the stream they asked for. Sending never waits."""

    def __init__(self, max_clients: int) -> None:
        self.max_clients = max_clients
        self.traffic = Traffic()
        self._rooms: dict[str, dict[str, dict[int, Client]]] = {}

    def join(self, room_id: str, client: Client) -> None:
        """Let a client watch a room; raises RoomFullError."""
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
        """How many watch this room, or one stream of it."""
        streams = self._rooms.get(room_id, {})
        if stream is not None:
            return len(streams.get(stream, ()))
        return sum(map(len, streams.values()))

    @property
    def total(self) -> int:
        return sum(map(self.count, self._rooms))

    def clients(self, room_id: str) -> list[Client]:
        return list(self._everyone(room_id))

    def announce(
        self,
        room_id: str,
        stream: str,
        event: bytes,
        requester: int | None = None,
        own: bytes = b"",
    ) -> None:
        """Send the same event to all who watch this stream, but `own` to client `requester`."""
        message = WireMessage.of_text(event)
        for client in self._rooms.get(room_id, {}).get(stream, {}).values():
            client.post(message if client.id != requester else WireMessage.of_text(own))

    def notify(self, room_id: str, client_id: int, event: bytes) -> None:
        """Send an event to one client, if it is still there."""
        for clients in self._rooms.get(room_id, {}).values():
            if client_id in clients:
                clients[client_id].post(WireMessage.of_text(event))

    def publish(
        self, room_id: str, stream: str, events: bytes | None, snapshot: bytes | None
    ) -> None:
        """Send a tick's events and snapshot to all who watch this stream: the same bytes to all."""
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
        """End every connection to the room with this reason."""
        for client in self._everyone(room_id):
            client.end(error)

    def cut(self, room_id: str, error: AppError) -> None:
        """End every connection to the room with this reason, and send nothing more before."""
        for client in self.clients(room_id):
            client.fail(error)

    def _everyone(self, room_id: str) -> Iterator[Client]:
        for clients in self._rooms.get(room_id, {}).values():
            yield from clients.values()
