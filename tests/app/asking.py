"""Players' drops and changes in tests: each runs in its own task, as on a server."""

import asyncio
from typing import Any

from plinko.app.live.broadcast.audience import Player
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.protocol import messages
from plinko.app.protocol.touching_messages import Change
from plinko.app.rooms.pending import DropCommand


def ask(
    live: LiveRoom,
    seed: int | None,
    x: float | None = None,
    *,
    stake: int = 0,
    session: FairSession | None = None,
    client: int | None = None,
    **values: Any,
) -> "asyncio.Task[messages.Accepted]":
    """Drop a ball in a new task; without a seed it is the next drop of a session."""
    practice = seed is not None or x is not None
    command = DropCommand(seed or 0, x, stake, practice=practice, **values)
    return asyncio.create_task(_accepted(live, command, Player(client=client), session))


async def _accepted(
    live: LiveRoom, command: DropCommand, player: Player, session: FairSession | None
) -> messages.Accepted:
    return (await live.drop(command, player, session)).accepted


def change(live: LiveRoom, asked: Change) -> "asyncio.Task[messages.Event | None]":
    """Change something in a room of touching balls, in a new task."""
    return asyncio.create_task(live.change(asked))
