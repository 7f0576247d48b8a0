"""Rebuilds a room of touching balls by replaying its inputs at their ticks. Pure."""

from collections import deque
from collections.abc import Sequence

from plinko.app.errors import DamagedRoomError, InvalidValueError
from plinko.app.rooms.kinds import BallLimits, draw_of, ground_of, make_room
from plinko.app.rooms.records import InputRow, RoomRow, StoredBasis
from plinko.app.rooms.room import Basis
from plinko.app.rooms.touching.room import TouchingRoom


class Replay:
    """The replay of a room from its checkpoint to its last input, or to its end if it is over.

    The caller hands in the inputs after the checkpoint in order, in pages of any size. A sleeping
    room does not tick, so a replay ends before the last tick if nothing moves any more.

    Raises RecordError if the checkpoint has another board, physics version or tick rate.
    """

    def __init__(self, row: RoomRow, basis: Basis, *, limits: BallLimits) -> None:
        room = make_room(row.id, basis, row.mode, tick_rate=row.tick_rate, limits=limits)
        assert isinstance(room, TouchingRoom)
        self.room = room
        if row.checkpoint is not None:
            self.room.restore(row.checkpoint)
        if self.room.input_count != row.checkpoint_drops:
            raise DamagedRoomError(
                f"the checkpoint of run {row.number} has {self.room.input_count} inputs, but its "
                f"row says {row.checkpoint_drops}"
            )
        self.first_tick = self.room.world.tick
        self._row = row
        self._inputs: deque[InputRow] = deque()

    @property
    def next_input(self) -> int:
        """The number of the first input that has not been handed in."""
        return self.room.input_count + len(self._inputs)

    def take(self, taken: Sequence[InputRow]) -> None:
        """Hand in the next inputs, those from `next_input` on."""
        self._inputs.extend(taken)

    def run(self, *, to_end: bool) -> None:
        """Replay up to the last input that was handed in or, with `to_end`, the run's last tick.

        Raises DamagedRoomError for an input that the room cannot have accepted at its tick, and
        the errors of `Room.replay` for one that it cannot have accepted at all.
        """
        self._carry_out()
        while self._inputs or (
            to_end and self.room.awake and self.room.world.tick < self._row.tick
        ):
            self.room.step(watched=False)
            self._carry_out()

    def _carry_out(self) -> None:
        room = self.room
        while self._inputs and self._inputs[0].tick <= room.world.tick:
            row = self._inputs.popleft()
            if row.tick < room.world.tick:
                raise self._misplaced(row, f"but the input before it has tick {room.world.tick}")
            room.replay(room.format.entry(row, None, row.tick))
        # An input is planned at most a second after the mark that is written with it. A later tick
        # is damage, and replaying up to it could take for ever.
        if self._inputs and self._inputs[0].tick > self._row.tick + self._row.tick_rate:
            raise self._misplaced(self._inputs[0], f"but its run ended at tick {self._row.tick}")

    def _misplaced(self, row: InputRow, why: str) -> DamagedRoomError:
        return DamagedRoomError(f"input {row.number} of run {row.room} has tick {row.tick}, {why}")


def basis_of(row: RoomRow, kept: StoredBasis) -> Basis:
    """Parse a run's board or draw, and compare its digest; raises DamagedRoomError."""
    if kept.board is None:
        raise DamagedRoomError(f"its board {row.board} is missing")
    try:
        ground = ground_of(row.mode, kept.board)
    except (ValueError, TypeError, KeyError) as error:
        raise DamagedRoomError(f"its board {row.board} is invalid: {error}") from error
    if ground.digest != row.board:
        raise DamagedRoomError(f"its board {row.board} has digest {ground.digest}")
    if row.draw is None:
        return ground
    if kept.draw is None:
        raise DamagedRoomError(f"its draw {row.draw} is missing")
    try:
        draw = draw_of(ground, kept.draw)
    except (InvalidValueError, ValueError, TypeError, KeyError) as error:
        raise DamagedRoomError(f"its draw {row.draw} is invalid: {error}") from error
    if draw.digest != row.draw:
        raise DamagedRoomError(f"its draw {row.draw} has digest {draw.digest}")
    return draw
