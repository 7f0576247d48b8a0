"""From the ledger's rows back to the room they came from, pure: inputs replayed at their ticks."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import msgspec

from app.protocol import messages
from app.rooms.independent import DropCommand
from app.rooms.kinds import AnyRoom, ArenaRoom, BallLimits, Ground, Room, make_room
from app.rooms.records import DropRow, InputRow, ResultRow, RoomRow
from engine import Board

Kept = Sequence[tuple[DropRow, ResultRow | None]]


@dataclass(slots=True)
class Rebuilt:
    """A room as it was, what landed on the way there, and what of it the ledger says otherwise."""

    room: AnyRoom
    results: list[ResultRow] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)


def rebuild(row: RoomRow, board: Board, drops: Kept, *, max_balls: int) -> Rebuilt:
    """The room of a sitting at its last known tick, from its checkpoint and the `drops` after it.

    Earlier ones among `drops` lend their results to be compared with what the replay gives. A room
    that sleeps does not tick, so the tick is only reached as long as something moves.
    Raises RecordError for a checkpoint of another board, physics or tick rate.
    """
    room = Room(row.id, board, tick_rate=row.tick_rate, max_balls=max_balls + len(drops))
    if row.checkpoint is not None:
        room.restore(row.checkpoint)
    rebuilt = Rebuilt(room)
    recorded = {drop.ball: result for drop, result in drops if result is not None}
    for drop, _ in drops:
        if drop.ball < room.drops:
            continue
        while room.world.tick < drop.tick:
            _step(rebuilt, row.number, recorded)
        room.drop(command_of(drop))
    while room.awake and room.world.tick < row.tick:
        _step(rebuilt, row.number, recorded)
    room.max_balls = max_balls
    return rebuilt


def rebuild_arena(
    row: RoomRow, ground: Ground, inputs: Sequence[InputRow], *, limits: BallLimits
) -> Rebuilt:
    """The same for a room whose balls touch each other, from its checkpoint and later `inputs`."""
    room = make_room(row.id, ground, row.mode, tick_rate=row.tick_rate, limits=limits)
    assert isinstance(room, ArenaRoom)
    if row.checkpoint is not None:
        room.restore(row.checkpoint)
    for each in inputs:
        while room.world.tick < each.tick:
            room.step(watched=False)
        room.replay(msgspec.json.decode(each.data))
    while room.awake and room.world.tick < row.tick:
        room.step(watched=False)
    return Rebuilt(room)


def finish(rebuilt: Rebuilt, number: int, most: int) -> bool:
    """Let all that moves land, in at most `most` ticks; returns whether it did."""
    for _ in range(most):
        if not rebuilt.room.awake:
            break
        _step(rebuilt, number, {})
    return not rebuilt.room.awake


def command_of(drop: DropRow) -> DropCommand:
    """The command that a drop came from."""
    return DropCommand(drop.seed, drop.x, drop.stake, drop.who)


def result_of(number: int, landed: messages.Landed) -> ResultRow:
    """What the ledger keeps of a landing in the sitting `number`."""
    return ResultRow(
        room=number,
        ball=landed.ball,
        tick=landed.tick,
        bin=landed.bin,
        score=landed.score,
        t=landed.t,
        x_end=landed.x_end,
        digest=landed.digest or "",
        unsettled=landed.unsettled,
        payout=landed.paid,
    )


def _step(rebuilt: Rebuilt, number: int, recorded: dict[int, ResultRow]) -> None:
    for event in rebuilt.room.step(watched=False):
        if not isinstance(event, messages.Landed):
            continue
        result = result_of(number, event)
        known = recorded.get(event.ball)
        if known is None:
            rebuilt.results.append(result)
        elif known != result:
            rebuilt.differences.append(f"the ledger says {known}, the replay gives {result}")
