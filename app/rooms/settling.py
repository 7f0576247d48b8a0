"""How what falls in a room ends, computed at once: a path is fixed when its drop was taken.

A ball may bounce millions of times, which takes minutes to compute. A room with such a ball goes on
until the ball has landed: to give the stake back instead would let a loser reset in time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from app.errors import BusyError
from app.protocol import messages
from app.rooms.kinds import BallLimits, make_room
from app.rooms.pending import Entered, Pending
from app.rooms.room import Room

MOST_EFFORT: Final = 10_000
"""Ticks, and pieces of paths, that are computed at once: a second or two. 200 balls on a preset
have some 600 of them."""


@dataclass(frozen=True, slots=True)
class Settled:
    """What enters and what lands in a room until nothing moves there, and the tick of that."""

    entered: list[Entered]
    landed: list[messages.Landed]
    tick: int


def settle(room: Room, checkpoint: bytes, planned: Sequence[Pending]) -> Settled:
    """The end of a run of independent balls that was saved as `checkpoint` with these to enter.

    All of them are durable. The room itself is only asked what it is: it may go on meanwhile, on
    another thread. Raises BusyError for what takes more than MOST_EFFORT.
    """
    limits = BallLimits(room.max_balls, room.max_balls)
    basis = room.basis_after_reset()
    copy = make_room(room.id, basis, room.mode, tick_rate=room.tick_rate, limits=limits)
    copy.restore(checkpoint)
    copy.planned.extend(planned)
    entered, landed = copy.enter(), list[messages.Landed]()
    for _ in range(MOST_EFFORT):
        if not copy.awake:
            return Settled(entered, landed, copy.world.tick)
        if not copy.look_ahead():
            landed += [e for e in copy.step(watched=False) if isinstance(e, messages.Landed)]
            entered += copy.enter()
    raise BusyError(
        f"what falls in room {room.id!r} takes too long to compute at once; the room can be closed "
        "or begun anew when it has landed",
        field="room",
        retry_after=10.0,
    )
