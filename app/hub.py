"""Who watches which room, and what waits to be sent to each client.

Two lanes a client. Events are reliable: queued in order, up to a bound. Snapshots are lossy: one
slot, and a newer one takes the place of the older. Each client has its own writer, so one that
stops reading stops only itself. When a write takes longer than the grace period, or the queue
overflows, the client is too slow and is closed with that reason.
"""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable

from app.errors import AppError, RoomFullError, SlowClientError

Frame = str | bytes  # a text frame's string, or a binary frame's bytes


class Mailbox:
    """What waits for one client, pure: bounded events in order, and the latest snapshot."""

    def __init__(self, max_events: int, max_bytes: int) -> None:
        self.max_events = max_events
        self.max_bytes = max_bytes
        self.replaced = 0  # snapshots that a newer one overtook
        self._events: deque[str] = deque()
        self._size = 0
        self._snapshot: bytes | None = None

    def post(self, event: str) -> None:
        """Queue an event; raises SlowClientError when the queue is full."""
        if len(self._events) >= self.max_events or self._size + len(event) > self.max_bytes:
            raise SlowClientError(
                f"{len(self._events)} event frames of {self._size} bytes wait unread"
            )
        self._events.append(event)
        self._size += len(event)

    def show(self, snapshot: bytes) -> None:
        """Put a snapshot in the slot; the one that was there is gone."""
        self.replaced += self._snapshot is not None
        self._snapshot = snapshot

    def take(self) -> Frame | None:
        """The next frame to send: events first, so that a snapshot never runs ahead of them."""
        if self._events:
            event = self._events.popleft()
            self._size -= len(event)
            return event
        snapshot, self._snapshot = self._snapshot, None
        return snapshot


class Client:
    """One connection: its mailbox and the writer that empties it."""

    def __init__(
        self,
        client_id: int,
        send: Callable[[Frame], Awaitable[None]],
        mailbox: Mailbox,
        grace: float,
    ) -> None:
        self.id = client_id
        self.mailbox = mailbox
        self.sent = 0  # frames
        self._send = send
        self._grace = grace
        self._wake = asyncio.Event()
        self._writing: asyncio.Timeout | None = None
        self._failure: AppError | None = None

    def post(self, event: str) -> None:
        """Queue an event; a client whose queue is full is on its way out."""
        try:
            self.mailbox.post(event)
        except SlowClientError as error:
            self.fail(error)
        self._wake.set()

    def fail(self, error: AppError) -> None:
        """End the connection with this reason: `write` raises it, even out of a blocked send."""
        self._failure = self._failure or error
        if self._writing is not None and not self._writing.expired():
            self._writing.reschedule(asyncio.get_running_loop().time())
        self._wake.set()

    def show(self, snapshot: bytes) -> None:
        """Offer a snapshot."""
        self.mailbox.show(snapshot)
        self._wake.set()

    async def write(self) -> None:
        """Send what waits, for ever; raises SlowClientError when the client does not read."""
        while True:
            while self._failure is None and (frame := self.mailbox.take()) is not None:
                await self._write_one(frame)
            if self._failure is not None:
                raise self._failure
            self._wake.clear()
            await self._wake.wait()

    async def _write_one(self, frame: Frame) -> None:
        try:
            async with asyncio.timeout(self._grace) as self._writing:
                await self._send(frame)
        except TimeoutError:
            raise self._failure or SlowClientError(
                f"nothing was read for {self._grace:g} seconds"
            ) from None
        finally:
            self._writing = None
        self.sent += 1


class Hub:
    """The clients of every room. Sending never waits: it only fills mailboxes."""

    def __init__(self, max_clients: int) -> None:
        self.max_clients = max_clients
        self._rooms: dict[str, dict[int, Client]] = {}

    def join(self, room_id: str, client: Client) -> None:
        """Let a client watch a room; raises RoomFullError."""
        clients = self._rooms.setdefault(room_id, {})
        if len(clients) >= self.max_clients:
            raise RoomFullError(f"room {room_id!r} already has {self.max_clients} clients")
        clients[client.id] = client

    def leave(self, room_id: str, client: Client) -> None:
        """Forget a client."""
        clients = self._rooms.get(room_id, {})
        clients.pop(client.id, None)
        if not clients:
            self._rooms.pop(room_id, None)

    def count(self, room_id: str) -> int:
        """How many watch this room."""
        return len(self._rooms.get(room_id, ()))

    def clients(self, room_id: str) -> list[Client]:
        """Those who watch this room."""
        return list(self._rooms.get(room_id, {}).values())

    def announce(self, room_id: str, event: bytes, skip: int | None = None) -> None:
        """Queue the same event frame for everyone in the room, all but client `skip`."""
        text = event.decode()
        for client in self._rooms.get(room_id, {}).values():
            if client.id != skip:
                client.post(text)

    def tell(self, room_id: str, client_id: int, event: bytes) -> None:
        """Queue an event frame for one client, if it is still there."""
        client = self._rooms.get(room_id, {}).get(client_id)
        if client is not None:
            client.post(event.decode())

    def show(self, room_id: str, snapshot: bytes) -> None:
        """Offer the same snapshot bytes to everyone in the room."""
        for client in self._rooms.get(room_id, {}).values():
            client.show(snapshot)

    def close(self, room_id: str, error: AppError) -> None:
        """End every connection to the room with this reason."""
        for client in self._rooms.get(room_id, {}).values():
            client.fail(error)
