"""What players ask of rooms in a test, each in a task of its own as on a server."""

import asyncio
from typing import Any

from app.live.broadcast.audience import Player
from app.live.live_room import LiveRoom
from app.live.sessions.fair_session import FairSession
from app.protocol import messages
from app.protocol.touching_messages import Change
from app.rooms.pending import DropCommand


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
    """Have a ball dropped; without a seed it is the next one of a session."""
    practice = seed is not None or x is not None
    command = DropCommand(seed or 0, x, stake, practice=practice, **values)
    return asyncio.create_task(live.drop(command, Player(client=client), session))


def change(live: LiveRoom, asked: Change) -> "asyncio.Task[messages.Event | None]":
    """Have something changed in a room whose balls touch each other."""
    return asyncio.create_task(live.change(asked))
