"""Computes at once where the balls in flight will land, for a room that is to end.

That is possible because a drop's path is fixed when the room accepts it. A ball may bounce millions
of times, which takes minutes to compute. A room with such a ball cannot end before it has landed:
if its stake were paid back instead, a player who sees a loss coming could reset the room in time.
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
"""Ticks plus calls of `look_ahead`: a second or two. 200 balls on a preset take some 600."""


@dataclass(frozen=True, slots=True)
class Settled:
    """The inputs and landings until nothing moves in the room any more, at `tick`."""

    entered: list[Entered]
    landed: list[messages.Landed]
    tick: int


def settle(room: Room, checkpoint: bytes, planned: Sequence[Pending]) -> Settled:
    """Run a copy of a room of independent balls, from `checkpoint` until nothing moves.

    `planned`: the inputs that have yet to enter, all of them durable. Only constants of `room`
    are read, so it may tick on another thread meanwhile. Raises BusyError if the balls take more
    than MOST_EFFORT.
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
        f"the balls in flight in room {room.id!r} take too long to compute; close or reset the "
        "room when they have landed",
        field="room",
        retry_after=10.0,
    )
