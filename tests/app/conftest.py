"""A real server on a free port of the loopback, in a thread, and clients to talk to it."""

import asyncio
import contextlib
import functools
import threading
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from typing import Any

import httpx
import msgspec
import pytest
from websockets.asyncio.client import ClientConnection, connect

from app.conformance import inventory
from app.listening import Server, listen, server_over
from app.main import create_app
from app.protocol.messages import Extent
from app.settings import Settings
from app.web.routes.page import Release
from app.web.services import Services
from tests.app.protocol.decoders import Snapshot, decode_snapshot
from tests.waiting import LIMIT

# A board whose balls land in two thirds of a second: live tests wait for real falls.
TINY = {
    "name": "tiny",
    "width": 3.0,
    "height": 2.0,
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "walls": [
        {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 2.0},
        {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 2.0},
    ],
    "bins": {"y": 2.0, "edges": [-1.5, 0.0, 1.5], "multipliers": [1.0, 2.0]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}


@dataclass(frozen=True)
class Running:
    """A running server: where it is, and its parts, whose counts tests may read."""

    url: str
    services: Services
    uvicorn: Server

    @property
    def connections(self) -> int:
        """Open connections, HTTP and WebSocket."""
        return len(self.uvicorn.server_state.connections)

    def socket(self, room: str = "main") -> str:
        return f"ws{self.url.removeprefix('http')}/ws/rooms/{room}"


@pytest.fixture(scope="session", autouse=True)
def files_read_once() -> Iterator[None]:
    """What servers of this process make of the program's files, the first one makes for all.

    That is half of what a start takes, and nothing changes these files while they are tested.
    """
    once = functools.cache(lambda: inventory.files_of(inventory.installed()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            inventory,
            "digests",
            lambda settings: inventory.digests_of(once(), inventory.configuration_of(settings)),
        )
        patch.setattr(Release, "of", functools.cache(Release.of))
        yield


@contextlib.contextmanager
def serving(**settings: Any) -> Iterator[Running]:
    """Run a server with these settings until the block ends."""
    chosen = Settings(**{"port": 0, "database_url": "sqlite://", **settings})
    app = create_app(chosen)
    listener = listen(chosen)
    server = server_over(app, chosen)
    thread = threading.Thread(target=server.run, args=([listener],), name="server")
    port = listener.getsockname()[1]
    thread.start()
    try:
        while not server.listening.wait(0.1):
            assert thread.is_alive(), "the server ended while it was to start"
        yield Running(f"http://127.0.0.1:{port}", app.state.services, server)
    finally:
        server.should_exit = True
        thread.join()
        listener.close()  # one that failed to start has left it open


@contextlib.contextmanager
def constants(**values: Any) -> Iterator[None]:
    """Constants of modules have these values: `{"app.listening.HEAD_SECONDS": 0.2}`."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in values.items():
            patch.setattr(name, value)
        yield


@pytest.fixture(scope="session")
def server() -> Iterator[Running]:
    with contextlib.ExitStack() as stack:
        with constants(**{"app.main.COMPUTE_BURST": 1e6}):
            running = stack.enter_context(serving(drop_rate=1000.0, creator_rooms=1000))
        yield running


@pytest.fixture(scope="session")
def http(server: Running) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=server.url, timeout=60.0) as client:
        yield client


class Player:
    """A client of a room that keeps what it was sent: events one by one, snapshots decoded."""

    def __init__(self, socket: ClientConnection, hello: dict[str, Any], first: str) -> None:
        self.socket = socket
        self.hello = hello
        self.texts = [first]
        self.binaries: list[bytes] = []
        self.events: list[dict[str, Any]] = []
        self._extent = msgspec.convert(hello["extent"], Extent) if "extent" in hello else None

    async def send(self, **message: Any) -> None:
        await self.socket.send(msgspec.json.encode(message).decode())

    async def step(self) -> list[dict[str, Any]] | bytes:
        """The next frame: its events, or a snapshot's bytes."""
        async with asyncio.timeout(LIMIT):
            frame = await self.socket.recv()
        if isinstance(frame, bytes):
            self.binaries.append(frame)
            return frame
        self.texts.append(frame)
        value = msgspec.json.decode(frame)
        events = value if isinstance(value, list) else [value]
        self.events += events
        return events

    def kinds(self) -> list[str]:
        """The types of all events so far."""
        return [event["type"] for event in self.events]

    async def until(self, kind: str, **fields: Any) -> dict[str, Any]:
        """Read on until an event of this type with these fields comes."""
        while True:
            events = await self.step()
            for event in events if isinstance(events, list) else ():
                if event["type"] == kind and fields.items() <= event.items():
                    return event

    async def until_empty(self) -> None:
        """Read on until the empty snapshot that ends a flight."""
        while True:
            frame = await self.step()
            if isinstance(frame, bytes) and not len(self.decode(frame).balls):
                return

    def decode(self, frame: bytes) -> Snapshot:
        assert self._extent is not None
        return decode_snapshot(frame, self._extent, self.hello["velocity_scale"])


@contextlib.asynccontextmanager
async def playing(url: str, **options: Any) -> AsyncIterator[Player]:
    """Join a room; `options` go to the connection."""
    # With a bound the client would stop reading, and then not hear the answer to its own close.
    async with connect(url, **{"compression": None, "max_queue": None, **options}) as socket:
        first = await socket.recv()
        assert isinstance(first, str)
        yield Player(socket, msgspec.json.decode(first), first)
