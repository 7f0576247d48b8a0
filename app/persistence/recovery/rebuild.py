"""From the ledger's rows back to the room they came from, pure: inputs replayed at their ticks."""

from collections import deque
from collections.abc import Iterable, Sequence

from app.errors import DamagedRoomError, InvalidValueError
from app.protocol import messages
from app.rooms.kinds import BallLimits, draw_of, ground_of, make_room
from app.rooms.records import KeptBasis, ResultRow, RoomRow, TakenRow
from app.rooms.room import Basis

Taken = Sequence[tuple[TakenRow, ResultRow | None]]
"""Inputs of a room in order, each with its result if it has one."""


class Replay:
    """A room on its way back, from its checkpoint to the last tick that its run may have shown.

    Inputs after the checkpoint are handed in in order, in pages of any size. What lands on the way
    is compared with the result that the ledger has, or is a result that it lacks. A room that
    sleeps does not tick, so the last tick is only reached as long as something moves.

    Raises RecordError for a checkpoint of another board, physics or tick rate.
    """

    def __init__(self, row: RoomRow, basis: Basis, *, limits: BallLimits) -> None:
        self.room = make_room(row.id, basis, row.mode, tick_rate=row.tick_rate, limits=limits)
        if row.checkpoint is not None:
            self.room.restore(row.checkpoint)
        if self.room.taken != row.checkpoint_drops:
            raise DamagedRoomError(
                f"the checkpoint of run {row.number} took {self.room.taken} inputs, its row "
                f"says {row.checkpoint_drops}"
            )
        self.first_tick = self.room.world.tick
        self.differences: list[str] = []
        self._row = row
        self._inputs: deque[TakenRow] = deque()
        self._recorded: dict[int, ResultRow] = {}  # by ball, as the ledger says
        self._results: list[ResultRow] = []

    @property
    def next_input(self) -> int:
        """Number of the first input that was not handed in."""
        return self.room.taken + len(self._inputs)

    @property
    def oldest_in_flight(self) -> int:
        """The first drop whose landing lies ahead, or the next input's number if none is."""
        return min((ball.ball for ball in self.room.balls), default=self.room.taken)

    def expect(self, results: Iterable[ResultRow]) -> None:
        """Hand in results to be compared with how balls land; earlier ones are left aside."""
        self._recorded |= {each.ball: each for each in results if each.tick > self.first_tick}

    def take(self, taken: Taken) -> None:
        """Hand in the next inputs; raises DamagedRoomError where one is missing."""
        for row, result in taken:
            if row.number != self.next_input:
                raise DamagedRoomError(
                    f"run {self._row.number} of the ledger lacks input {self.next_input}"
                )
            self._inputs.append(row)
            if result is not None:
                self.expect([result])

    def take_results(self) -> list[ResultRow]:
        """What has landed since the last call and is not in the ledger."""
        results, self._results = self._results, []
        return results

    def run(self, ticks: int, *, to_end: bool) -> bool:
        """Go on by at most so many ticks; True when it is there.

        There is the last input that was handed in, with `to_end` the run's last tick. Raises
        DamagedRoomError for an input that cannot have been taken at its tick, what `Room.replay`
        raises for one that cannot have been taken at all.
        """
        for _ in range(ticks):
            self._carry_out()
            ends = not (to_end and self.room.awake and self.room.world.tick < self._row.tick)
            if not self._inputs and ends:
                if to_end:
                    self._miss()
                return True
            self._step()
        return False

    def _miss(self) -> None:
        """Note the results that should have come out by now."""
        over = self._row.closed is not None
        for result in self._recorded.values():
            # What was given up when a run ended has a result that no replay gives.
            if result.tick <= self.room.world.tick and (result.digest or not over):
                self.differences.append(f"the ledger says {result}, the replay gives none")

    def finish(self, ticks: int) -> bool:
        """Let what moves land, in at most so many ticks; True when all of it has."""
        for _ in range(ticks):
            if not self.room.awake:
                break
            self._step()
        return not self.room.awake

    def _carry_out(self) -> None:
        room = self.room
        while self._inputs and self._inputs[0].tick <= room.world.tick:
            row = self._inputs.popleft()
            if row.tick < room.world.tick:
                raise self._misplaced(row, f"which was over at tick {room.world.tick}")
            room.replay(room.format.entry(row, None, row.tick))
        # A drop is planned some moments ahead of what its run may have shown, never more.
        if self._inputs and self._inputs[0].tick > self._row.tick + self._row.tick_rate:
            raise self._misplaced(self._inputs[0], f"its run came to tick {self._row.tick}")

    def _misplaced(self, row: TakenRow, why: str) -> DamagedRoomError:
        return DamagedRoomError(
            f"input {row.number} of run {row.room} is of tick {row.tick}, {why}"
        )

    def _step(self) -> None:
        for event in self.room.step(watched=False):
            if not isinstance(event, messages.Landed):
                continue
            result = self.room.format.result(self._row.number, event)
            if result is None:
                continue
            known = self._recorded.pop(event.ball, None)
            if known is None:
                self._results.append(result)
            elif known != result:
                self.differences.append(f"the ledger says {known}, the replay gives {result}")


def basis_of(row: RoomRow, kept: KeptBasis) -> Basis:
    """What a run is made of, from what the ledger has; raises DamagedRoomError."""
    if kept.board is None:
        raise DamagedRoomError(f"its board {row.board} is missing")
    try:
        ground = ground_of(row.mode, kept.board)
    except (ValueError, TypeError, KeyError) as error:
        raise DamagedRoomError(f"its board {row.board} is none: {error}") from error
    if ground.digest != row.board:
        raise DamagedRoomError(f"its board {row.board} has digest {ground.digest}")
    if row.draw is None:
        return ground
    if kept.draw is None:
        raise DamagedRoomError(f"its draw {row.draw} is missing")
    try:
        draw = draw_of(ground, kept.draw)
    except (InvalidValueError, ValueError, TypeError, KeyError) as error:
        raise DamagedRoomError(f"its draw {row.draw} is none: {error}") from error
    if draw.digest != row.draw:
        raise DamagedRoomError(f"its draw {row.draw} has digest {draw.digest}")
    return draw


def rebuild(row: RoomRow, basis: Basis, taken: Taken, *, limits: BallLimits) -> Replay:
    """The room of a run at its last tick, from its checkpoint and the inputs after it, at once.

    Inputs before the checkpoint among `taken` lend their results to be compared with the replay's.
    """
    replay = Replay(row, basis, limits=limits)
    before = [result for each, result in taken if each.number < replay.room.taken]
    replay.expect(result for result in before if result is not None)
    replay.take(taken[len(before) :])
    while not replay.run(row.tick_rate, to_end=True):
        pass
    return replay
