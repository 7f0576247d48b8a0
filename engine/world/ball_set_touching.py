"""The balls of a world that touch each other: an arena behind the methods of the other crowds."""

from typing import Any

import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.constants import KIND_BALL, KIND_LANDING, KIND_PEG, KIND_WALL
from engine.drops.digest import drop_digest
from engine.exact import event_log
from engine.exact.outcome import BALANCED, ESCAPED, LANDED, MAX_TIME, TIME_LIMIT
from engine.multibody.arena import Arena
from engine.multibody.events import Landed, Left, Touch
from engine.multibody.settings import ArenaSettings
from engine.multibody.static_geometry import Place
from engine.parameters import Touching
from engine.physics import body
from engine.world.progress import End, Progress

Floats = npt.NDArray[np.float64]

_KINDS = {"peg": KIND_PEG, "wall": KIND_WALL, "ball": KIND_BALL}


class TouchingCrowd:
    """Balls of one board that touch each other; one that comes to rest ends as balanced.

    A ball's path depends on all others, so its digest is of its start and its end alone.
    """

    def __init__(self, board: Board, solver: Touching) -> None:
        self._board = board
        self._solver = solver
        self.arena = Arena(
            Place.of_board(board),
            ArenaSettings(
                gravity=board.gravity,
                drag=board.drag,
                correction=solver.correction,
                dt=solver.dt,
                substeps=solver.substeps,
            ),
        )
        self._ids: list[int] = []
        self._starts: list[tuple[int, float]] = []  # tick and x of each
        self.states = np.zeros((0, body.SIZE))

    def add(self, x: float) -> None:
        """Append a ball at rest at (x, drop.y)."""
        ball = self._board.ball
        self._ids.append(
            self.arena.add(
                x,
                self._board.drop.y,
                radius=ball.radius,
                density=ball.density,
                restitution=ball.restitution,
                friction=ball.friction,
            )
        )
        self._starts.append((self.arena.tick, x))
        state = np.zeros((1, body.SIZE))
        state[0, [body.X, body.Y]] = x, self._board.drop.y
        self.states = np.concatenate([self.states, state])

    def step(self) -> list[Progress]:
        """Advance all balls by one frame."""
        self.arena.step()
        rows = {ball: row for row, ball in enumerate(self._ids)}
        found: dict[int, list[tuple[Touch, int, int]]] = {}
        ends: dict[int, End] = {}
        for event in self.arena.take_events():
            if isinstance(event, Touch):
                kind = _KINDS[event.kind]
                index = event.b if kind == KIND_BALL else event.index
                found.setdefault(rows[event.a], []).append((event, kind, index))
            else:
                ends[rows[event.ball]] = self._end(rows[event.ball], event)
        asleep = self._look(rows)
        for row in asleep:
            ends[row] = self._end(row, None)
        return [
            self._progress(row, found.get(row, []), ends.get(row))
            for row in sorted({*found, *ends})
        ]

    def _look(self, rows: dict[int, int]) -> list[int]:
        """Read the arena's balls; the rows of those that ended without landing."""
        bodies = self.arena.bodies
        here = np.array([rows[ball] for ball in bodies["id"].tolist()], np.intp)
        names = ("x", "y", "vx", "vy", "theta", "omega")
        for name, column in zip(
            names, (body.X, body.Y, body.VX, body.VY, body.THETA, body.OMEGA), strict=True
        ):
            self.states[here, column] = bodies[name]
        ticks = np.array([tick for tick, _ in self._starts], np.int64)
        self.states[:, body.T] = (self.arena.tick - ticks) * self._solver.dt
        over = (bodies["asleep"] != 0) | (self.states[here, body.T] > MAX_TIME)
        return [int(row) for row in here[over]]

    def _end(self, row: int, event: Landed | Left | None) -> End:
        tick, start = self._starts[row]
        board, state = self._board, self.states[row]
        outcome, where, t = LANDED, -1, (self.arena.tick - tick) * self._solver.dt
        if isinstance(event, Landed):
            where = event.bin
            t = event.t - tick * self._solver.dt
            state[[body.T, body.X, body.Y]] = t, event.x, board.bins.y
        elif event is not None:
            outcome = ESCAPED
        else:
            outcome = TIME_LIMIT if t > MAX_TIME else BALANCED
        events = np.array(
            [[t, state[body.X], state[body.Y], state[body.VX], state[body.VY], state[body.OMEGA]]]
        )
        marks = np.array([[KIND_LANDING, where]], np.int32)
        first = (start, board.drop.y, 0.0, 0.0, 0.0)
        digest = drop_digest(board.digest, self._solver, first, outcome, events, marks)
        return End(outcome, where, t, float(state[body.X]), digest)

    def _progress(
        self, row: int, touches: list[tuple[Touch, int, int]], end: End | None
    ) -> Progress:
        events = np.zeros((len(touches), event_log.EVENT_SIZE))
        marks = np.zeros((len(touches), 2), np.int32)
        speeds = np.zeros(len(touches))
        began = self._starts[row][0] * self._solver.dt
        for k, (touch, kind, index) in enumerate(touches):
            events[k, :3] = touch.t - began, touch.x, touch.y
            marks[k] = kind, index
            speeds[k] = touch.speed
        return Progress(row, events, marks, end, speeds)

    def remove(self, rows: list[int]) -> None:
        """Take out balls whose drop has ended."""
        there = set(self.arena.bodies["id"].tolist())
        self.arena.remove_many([self._ids[row] for row in sorted(rows) if self._ids[row] in there])
        self._ids = [ball for row, ball in enumerate(self._ids) if row not in rows]
        self._starts = [start for row, start in enumerate(self._starts) if row not in rows]
        self.states = np.delete(self.states, rows, axis=0)

    def saved(self) -> list[dict[str, Any]]:
        """What `load` needs of all balls."""
        return [
            {
                "arena": self.arena.snapshot(),
                "ids": self._ids,
                "starts": self._starts,
                "states": self.states.astype("<f8").tobytes(),
            }
        ]

    def load(self, balls: list[dict[str, Any]]) -> None:
        """Become the crowd that was saved."""
        saved = balls[0]
        self.arena.restore(saved["arena"])
        self._ids = list(saved["ids"])
        self._starts = [(tick, x) for tick, x in saved["starts"]]
        self.states = np.frombuffer(saved["states"], "<f8").reshape(-1, body.SIZE).copy()
