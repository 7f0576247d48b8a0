"""How what falls in a room ends, computed at once: a path is fixed when its drop was taken."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from app.protocol import messages
from app.rooms.kinds import BallLimits, make_room
from app.rooms.pending import Entered, PendingInput
from app.rooms.room import Room


@dataclass(frozen=True, slots=True)
class Settled:
    """What enters and what lands in a room until nothing moves there, and the tick of that."""

    entered: list[Entered]
    landed: list[messages.Landed]
    tick: int


def settle(room: Room, checkpoint: bytes, planned: Sequence[PendingInput[Any]]) -> Settled:
    """The end of a run of independent balls that was saved as `checkpoint` with these to enter.

    All of them are durable. The room itself is only asked what it is: it may go on meanwhile, on
    another thread.
    """
    limits = BallLimits(room.max_balls, room.max_balls)
    copy = make_room(room.id, room.origin, room.mode, tick_rate=room.tick_rate, limits=limits)
    copy.restore(checkpoint)
    copy.planned.extend(planned)
    entered, landed = copy.enter(), list[messages.Landed]()
    while copy.awake:
        landed += [e for e in copy.step(watched=False) if isinstance(e, messages.Landed)]
        entered += copy.enter()
    return Settled(entered, landed, copy.world.tick)
