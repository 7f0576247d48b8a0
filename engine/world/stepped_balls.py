"""The balls of a world with the stepped solver, which advances them substep by substep."""

from typing import Any

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.drops.digest import drop_digest
from plinko.engine.drops.trajectory import IMPACT, at_start, events_in, impacts_of, marks_in
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.outcome import RUNNING
from plinko.engine.parameters import Stepped
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats
from plinko.engine.stepped.step import ENDLESS, MAX_HITS, step_many
from plinko.engine.world.events import End, Progress


class SteppedBalls:
    """Balls of the stepped solver, as `ExactBalls`. Nothing can be computed before its step."""

    def __init__(self, board: Board, solver: Stepped) -> None:
        self._board = board
        self._arrays = arrays_of(board)
        self._solver = solver
        self._steps = np.zeros(0, np.int64)
        self._starts: list[float] = []
        self._impacts: list[list[npt.NDArray[np.void]]] = []
        self.states = np.zeros((0, body.SIZE))

    def add(self, x: float) -> None:
        self._append(at_start(self._board, x), 0, x)

    def _append(self, state: Floats, steps: int, start: float) -> None:
        self.states = np.vstack([self.states, state])
        self._steps = np.append(self._steps, steps)
        self._starts.append(start)
        self._impacts.append([])

    def step(self) -> list[Progress]:
        count = len(self.states)
        solver = self._solver
        log = new_log(count * (solver.substeps * MAX_HITS + 1), 0, count)
        outcomes = np.empty(count, np.int8)
        bins, counts = np.empty(count, np.int32), np.empty(count, np.int32)
        step_many(
            self._arrays, self.states, self._steps, solver.substeps, solver.h, solver.correction,
            ENDLESS, np.empty(body.SIZE), log, outcomes, bins, counts,
        )  # fmt: skip
        log_ends = log.ends[:, event_log.EVENTS]
        found = []
        for row, (first, last) in enumerate(zip([0, *log_ends[:-1]], log_ends, strict=True)):
            if first == last and outcomes[row] == RUNNING:
                continue
            impacts = impacts_of(log.events[first:last], log.marks[first:last])
            self._impacts[row].append(impacts)
            end = None
            if outcomes[row] != RUNNING:
                end = self._end(row, int(outcomes[row]), int(bins[row]))
            found.append(Progress(row, impacts, end))
        return found

    def _end(self, row: int, outcome: int, where: int) -> End:
        start = (self._starts[row], self._board.drop.y, 0.0, 0.0, 0.0)
        digest = drop_digest(self._board.digest, self._solver, start, outcome, self._all(row))
        state = self.states[row]
        return End(outcome, where, float(state[body.T]), float(state[body.X]), digest)

    def _all(self, row: int) -> npt.NDArray[np.void]:
        return np.concatenate([np.empty(0, IMPACT), *self._impacts[row]])

    def remove(self, rows: list[int]) -> None:
        for name in ("_starts", "_impacts"):
            kept = [item for row, item in enumerate(getattr(self, name)) if row not in rows]
            setattr(self, name, kept)
        self._steps = np.delete(self._steps, rows)
        self.states = np.delete(self.states, rows, axis=0)

    def saved(self) -> list[dict[str, Any]]:
        return [
            {
                "state": state.astype("<f8").tobytes(),
                "steps": int(steps),
                "start": start,
                "events": events_in(self._all(row)).tobytes(),
                "marks": marks_in(self._all(row)).tobytes(),
            }
            for row, (state, steps, start) in enumerate(
                zip(self.states, self._steps, self._starts, strict=True)
            )
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        for ball in balls:
            state = np.frombuffer(ball["state"], "<f8").astype(np.float64)
            self._append(state, ball["steps"], ball["start"])
            events = np.frombuffer(ball["events"], "<f8").reshape(-1, event_log.EVENT_SIZE)
            marks = np.frombuffer(ball["marks"], "<i4").reshape(-1, 2)
            self._impacts[-1].append(impacts_of(events, marks))
