"""Rebuilds a room from the ledger's rows by replaying its inputs at their ticks. Pure."""

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
    """The replay of a room from its checkpoint to the last tick that clients may have seen.

    The caller hands in the inputs after the checkpoint in order, in pages of any size. Each landing
    is compared with its result in the ledger, or is a new result if the ledger has none. A sleeping
    room does not tick, so the replay ends before the last tick if nothing moves any more.

    Raises RecordError if the checkpoint has another board, physics version or tick rate.
    """

    def __init__(self, row: RoomRow, basis: Basis, *, limits: BallLimits) -> None:
        self.room = make_room(row.id, basis, row.mode, tick_rate=row.tick_rate, limits=limits)
        if row.checkpoint is not None:
            self.room.restore(row.checkpoint)
        if self.room.taken != row.checkpoint_drops:
            raise DamagedRoomError(
                f"the checkpoint of run {row.number} has {self.room.taken} inputs, but its row "
                f"says {row.checkpoint_drops}"
            )
        self.first_tick = self.room.world.tick
        self.differences: list[str] = []
        self._row = row
        self._inputs: deque[TakenRow] = deque()
        self._recorded: dict[int, ResultRow] = {}  # the ledger's results, by ball
        self._results: list[ResultRow] = []

    @property
    def next_input(self) -> int:
        """The number of the first input that has not been handed in."""
        return self.room.taken + len(self._inputs)

    @property
    def oldest_in_flight(self) -> int:
        """The first drop in flight; without one, the next input's number."""
        return min((ball.ball for ball in self.room.balls), default=self.room.taken)

    def expect(self, results: Iterable[ResultRow]) -> None:
        """Hand in results to compare with; those from before the checkpoint are ignored."""
        self._recorded |= {each.ball: each for each in results if each.tick > self.first_tick}

    def take(self, taken: Taken) -> None:
        """Hand in the next inputs; raises DamagedRoomError if one is missing."""
        for row, result in taken:
            if row.number != self.next_input:
                raise DamagedRoomError(
                    f"run {self._row.number} of the ledger lacks input {self.next_input}"
                )
            self._inputs.append(row)
            if result is not None:
                self.expect([result])

    def take_results(self) -> list[ResultRow]:
        """Results since the last call that the ledger does not have."""
        results, self._results = self._results, []
        return results

    def run(self, ticks: int, *, to_end: bool) -> bool:
        """Replay at most `ticks` ticks; returns whether the goal is reached.

        The goal is the last input that was handed in or, with `to_end`, the run's last tick.
        Raises DamagedRoomError for an input that the room cannot have accepted at its tick, and
        the errors of `Room.replay` for one that it cannot have accepted at all.
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
        """Note the ledger's results that the replay should have reproduced by now."""
        over = self._row.closed is not None
        for result in self._recorded.values():
            # A drop that was given up when its run ended has a result without a digest, which no
            # replay can give.
            if result.tick <= self.room.world.tick and (result.digest or not over):
                self.differences.append(f"the ledger has {result}, but the replay gives none")

    def finish(self, ticks: int) -> bool:
        """Replay at most `ticks` ticks; returns whether all balls have landed."""
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
                raise self._misplaced(row, f"but the input before it has tick {room.world.tick}")
            room.replay(room.format.entry(row, None, row.tick))
        # A drop is planned at most a second after the last tick that clients may have seen. A later
        # tick is damage, and replaying up to it could take for ever.
        if self._inputs and self._inputs[0].tick > self._row.tick + self._row.tick_rate:
            raise self._misplaced(self._inputs[0], f"but its run ended at tick {self._row.tick}")

    def _misplaced(self, row: TakenRow, why: str) -> DamagedRoomError:
        return DamagedRoomError(f"input {row.number} of run {row.room} has tick {row.tick}, {why}")

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
                self.differences.append(f"the ledger has {known}, but the replay gives {result}")


def basis_of(row: RoomRow, kept: KeptBasis) -> Basis:
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


def rebuild(row: RoomRow, basis: Basis, taken: Taken, *, limits: BallLimits) -> Replay:
    """Replay a run to its last tick in one call, from its checkpoint and the inputs after it.

    `taken` may begin with inputs before the checkpoint: only their results are used.
    """
    replay = Replay(row, basis, limits=limits)
    before = [result for each, result in taken if each.number < replay.room.taken]
    replay.expect(result for result in before if result is not None)
    replay.take(taken[len(before) :])
    while not replay.run(row.tick_rate, to_end=True):
        pass
    return replay
