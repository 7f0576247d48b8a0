"""What the routes work with: made once at start-up, handed to each request."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

from app.boards import Boards
from app.cameras import Cameras
from app.hub import Hub
from app.ledger.writer import Ledger
from app.limits import KeyedBuckets, Quota
from app.metrics import Metrics
from app.pictures import Pictures
from app.rooms import Rooms
from app.settings import Settings
from app.tokens import Tokens
from app.workers import Workers


@dataclass(slots=True)
class Services:
    """The server's parts, and whether it is ready."""

    settings: Settings
    version: str
    boards: Boards
    hub: Hub
    rooms: Rooms
    ledger: Ledger
    tokens: Tokens
    workers: Workers
    pictures: Pictures
    moments: Pictures  # single frames of rooms
    cameras: Cameras
    room_drops: KeyedBuckets
    creators: Quota
    metrics: Metrics
    warm: bool = False
    transport: str = "public"  # how clients are written to; see app.transport
    ticking: "asyncio.Task[None] | None" = None
    client_ids: Iterator[int] = field(default_factory=count)

    @property
    def ticker_runs(self) -> bool:
        """Whether the ticker's task lives, asleep or not."""
        return self.ticking is not None and not self.ticking.done()
