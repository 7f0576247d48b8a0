"""From the ledger's rows back to the room they came from, pure: inputs replayed at their ticks."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from app.protocol import messages
from app.rooms.kinds import BallLimits, make_room
from app.rooms.records import ResultRow, RoomRow, TakenRow
from app.rooms.room import Ground, Room

Taken = Sequence[tuple[TakenRow, ResultRow | None]]
"""Inputs of a room in order, each with its result if it has one."""


@dataclass(slots=True)
class Rebuilt:
    """A room as it was, what landed on the way there, and what of it the ledger says otherwise."""

    room: Room
    session: int
    recorded: dict[int, ResultRow] = field(default_factory=dict)  # by ball, as the ledger says
    results: list[ResultRow] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)

    def step(self) -> None:
        """One tick on; what lands is compared, or is a result that the ledger lacks."""
        for event in self.room.step(watched=False):
            if not isinstance(event, messages.Landed):
                continue
            result = self.room.format.result(self.session, event)
            if result is None:
                continue
            known = self.recorded.get(event.ball)
            if known is None:
                self.results.append(result)
            elif known != result:
                self.differences.append(f"the ledger says {known}, the replay gives {result}")


def rebuild(row: RoomRow, ground: Ground, taken: Taken, *, limits: BallLimits) -> Rebuilt:
    """The room of a session at its last known tick, from its checkpoint and the inputs after it.

    Earlier ones among `taken` lend their results to be compared with what the replay gives. A room
    that sleeps does not tick, so the tick is only reached as long as something moves.
    Raises RecordError for a checkpoint of another board, physics or tick rate.
    """
    room = make_room(row.id, ground, row.mode, tick_rate=row.tick_rate, limits=limits)
    if row.checkpoint is not None:
        room.restore(row.checkpoint)
    recorded = {each.number: result for each, result in taken if result is not None}
    rebuilt = Rebuilt(room, row.number, recorded)
    for each, _ in taken:
        if each.number < room.taken:
            continue
        while room.world.tick < each.tick:
            rebuilt.step()
        room.replay(room.format.entry(each, None, each.tick))
    while room.awake and room.world.tick < row.tick:
        rebuilt.step()
    return rebuilt


def finish(rebuilt: Rebuilt, most: int) -> bool:
    """Let all that moves land, in at most `most` ticks; returns whether it did."""
    rebuilt.recorded = {}
    for _ in range(most):
        if not rebuilt.room.awake:
            break
        rebuilt.step()
    return not rebuilt.room.awake
