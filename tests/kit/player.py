"""A WebSocket client of a room, which records what the server sends."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from plinko.app.protocol.messages import Extent
from tests.app.protocol.decoders import Snapshot, decode_snapshot
from tests.kit.waiting import LIMIT


def joining(url: str, **options: Any) -> connect:
    """An unopened connection to a room; `options` go to websockets' `connect`."""
    # No bound on unread messages: a full queue would stop the client from reading, and it would
    # miss the server's reply to its own close frame. No pings, and patience: the machine is busy.
    usual = {"max_queue": None, "open_timeout": LIMIT, "ping_interval": None}
    return connect(url, **{"compression": None, **usual, **options})


def events_of(frame: str) -> list[dict[str, Any]]:
    """The events of a text frame, which is one event or a list."""
    value = msgspec.json.decode(frame)
    return value if isinstance(value, list) else [value]


def tick_of(snapshot: bytes) -> int:
    return int.from_bytes(snapshot[4:8], "little")


async def send(socket: ClientConnection, **message: Any) -> None:
    await socket.send(msgspec.json.encode(message).decode())


class Player:
    """A client of a room: it records text frames, their events, and binary frames."""

    def __init__(self, socket: ClientConnection, hello: dict[str, Any], first: str) -> None:
        self.socket = socket
        self.hello = hello
        self.texts = [first]
        self.binaries: list[bytes] = []
        self.events: list[dict[str, Any]] = []
        self._extent = msgspec.convert(hello["extent"], Extent) if "extent" in hello else None

    async def send(self, **message: Any) -> None:
        await send(self.socket, **message)

    async def step(self) -> list[dict[str, Any]] | bytes:
        """Receive the next frame; returns its events, or a snapshot's bytes."""
        async with asyncio.timeout(LIMIT):
            frame = await self.socket.recv()
        if isinstance(frame, bytes):
            self.binaries.append(frame)
            return frame
        self.texts.append(frame)
        events = events_of(frame)
        self.events += events
        return events

    def kinds(self) -> list[str]:
        """The types of all events received."""
        return [event["type"] for event in self.events]

    async def until(self, kind: str, **fields: Any) -> dict[str, Any]:
        """Read until an event has this type and these fields."""
        while True:
            events = await self.step()
            for event in events if isinstance(events, list) else ():
                if event["type"] == kind and fields.items() <= event.items():
                    return event

    async def closing(self) -> ConnectionClosed:
        """Read until the connection ends; returns how it ended."""
        while True:
            try:
                await self.step()
            except ConnectionClosed as closed:
                return closed

    async def closed(self) -> tuple[int, str]:
        """Read until the server closes the connection; returns the code and the reason."""
        frame = (await self.closing()).rcvd
        assert frame is not None, "the connection broke without a close frame"
        return frame.code, frame.reason

    async def until_empty(self) -> None:
        """Read until the empty snapshot that follows the last landing."""
        while True:
            frame = await self.step()
            if isinstance(frame, bytes) and not len(self.decode(frame).balls):
                return

    def decode(self, frame: bytes) -> Snapshot:
        assert self._extent is not None
        return decode_snapshot(frame, self._extent, self.hello["velocity_scale"])


@contextlib.asynccontextmanager
async def playing(url: str, **options: Any) -> AsyncIterator[Player]:
    """Join a room; `options` go to websockets' `connect`."""
    async with joining(url, **options) as socket:
        first = await socket.recv()
        assert isinstance(first, str)
        yield Player(socket, msgspec.json.decode(first), first)
