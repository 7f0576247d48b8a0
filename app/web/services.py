"""The objects that the routes use: made once at start, available to each request."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING

from app.computing.pool import Workers
from app.computing.short import ShortDrops
from app.conformance.self_check import SelfCheck
from app.live.broadcast.hub import Hub
from app.live.registry import Rooms
from app.live.sessions.fair_sessions import FairSessions
from app.ops.metrics import Metrics
from app.persistence.checks.integrity import Integrity
from app.persistence.ledger.writer import Ledger
from app.persistence.room_log import RoomLogs
from app.pictures.cache import Pictures
from app.pictures.film import Cameras
from app.rooms.boards import Boards
from app.settings import Settings
from app.web.limits import Budgets, KeyedBuckets, Quota
from app.web.returns import Returns
from app.web.shared import Others
from app.web.tokens import SessionTokens, Tokens

if TYPE_CHECKING:
    from app.webhooks.webhooks import Webhooks


@dataclass(slots=True)
class Services:
    """The server's parts, and whether it is ready."""

    settings: Settings
    version: str
    boards: Boards
    hub: Hub
    rooms: Rooms
    ledger: Ledger
    integrity: Integrity
    self_check: SelfCheck
    returns: Returns
    tokens: Tokens
    fair: FairSessions
    session_tokens: SessionTokens
    workers: Workers
    short: ShortDrops
    readers: Workers
    """A process for long reads of the ledger only."""
    pictures: Pictures
    moments: Pictures  # single frames of rooms
    cameras: Cameras
    room_drops: KeyedBuckets
    creators: Quota
    budgets: Budgets
    logs: RoomLogs
    metrics: Metrics
    others: Others | None = None  # the other servers of a cluster
    webhooks: "Webhooks | None" = None
    warm: bool = False
    ticking: "asyncio.Task[None] | None" = None
    client_ids: Iterator[int] = field(default_factory=count)

    @property
    def ticker_runs(self) -> bool:
        """Whether the ticker's task is alive, asleep or not."""
        return self.ticking is not None and not self.ticking.done()
