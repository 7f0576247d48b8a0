"""The objects that the routes use: made once at start, available to each request."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import TYPE_CHECKING

from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.registry import Rooms
from plinko.app.live.sessions.fair_sessions import FairSessions
from plinko.app.ops.metrics import Metrics
from plinko.app.persistence.checks.integrity import Integrity
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.room_log import RoomLogs
from plinko.app.rooms.boards import Boards
from plinko.app.settings import Settings
from plinko.app.web.computing import Computing
from plinko.app.web.limits import KeyedBuckets, Quota
from plinko.app.web.returns import Returns
from plinko.app.web.shared import Others
from plinko.app.web.tokens import SessionTokens, Tokens

if TYPE_CHECKING:
    from plinko.app.webhooks.sender import Webhooks


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
    returns: Returns
    tokens: Tokens
    fair: FairSessions
    session_tokens: SessionTokens
    computing: Computing
    room_drops: KeyedBuckets
    creators: Quota
    logs: RoomLogs
    metrics: Metrics
    others: Others | None = None  # the other servers of a cluster
    webhooks: "Webhooks | None" = None
    warm: bool = False
    ticking: "asyncio.Task[None] | None" = None
    client_ids: Iterator[int] = field(default_factory=count)
