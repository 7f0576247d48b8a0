"""A board with balls on it that moves in fixed steps: what a live room ticks."""

import hashlib
from dataclasses import dataclass
from math import isfinite
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from engine.board.model import Board
from engine.constants import KIND_WALL, PHYSICS_VERSION
from engine.drops.start import start_of, unsigned_zero
from engine.drops.trajectory import Trajectory
from engine.errors import ParameterError, RecordError
from engine.exact.outcome import LANDED, REASONS
from engine.parameters import (
    DEFAULT_CORRECTION,
    DEFAULT_DT,
    DEFAULT_SUBSTEPS,
    Stepped,
    make_solver,
    number,
)
from engine.physics import body
from engine.seeding import parse_seed
from engine.world.ball_set import BallSet, Progress
from engine.world.events import Contact, Event, Landing, approach_speed
from engine.world.exact_balls import ExactBalls
from engine.world.stepped_balls import SteppedBalls
from engine.world.totals import Energy, Momentum, energy_of, momentum_of

BODY = np.dtype(
    [("id", "<i4")]
    + [(name, "<f8") for name in ("x", "y", "theta", "vx", "vy", "omega")]
    + [("bounced", "u1")]
)
"""A live ball: id, m, rad, m/s, rad/s, and whether it hit something in the last step."""

_COLUMNS = {
    "x": body.X,
    "y": body.Y,
    "theta": body.THETA,
    "vx": body.VX,
    "vy": body.VY,
    "omega": body.OMEGA,
}


@dataclass(frozen=True, slots=True)
class Ball:
    """How a ball began: its seed, its start in m, and the tick it started at."""

    id: int
    seed: int | None
    x: float
    tick: int


class World:
    """Balls on a board, advanced in steps of dt seconds by one of the two solvers.

    A ball starts at the tick at which it is added and leaves the world when its drop ends. With
    the exact solver dt only says when the world is looked at: each ball's path is that of `drop`.
    Balls pass through each other; those of `Arena` do not. `board` may be a preset's name.
    """

    def __init__(
        self,
        board: Board | str,
        *,
        solver: str = "exact",
        dt: float = DEFAULT_DT,
        substeps: int = DEFAULT_SUBSTEPS,
        correction: float = DEFAULT_CORRECTION,
    ) -> None:
        self.board = board = Board.named(board)
        self.dt = number(dt, "dt", 1e-6, 0.1)
        self.solver = make_solver(solver, dt, substeps, correction)
        self.tick = 0
        self._accumulator = 0.0
        self._next_id = 0
        self._balls: list[Ball] = []
        self._bounced = np.zeros(0, np.uint8)
        self._previous = np.zeros((0, 7))
        self._events: list[Event] = []
        self._ball_set = self._new_ball_set()

    def _new_ball_set(self) -> BallSet:
        if isinstance(self.solver, Stepped):
            return SteppedBalls(self.board, self.solver)
        return ExactBalls(self.board, self.dt)

    @property
    def time(self) -> float:
        """Seconds since the world began."""
        return self.tick * self.dt

    @property
    def awake(self) -> bool:
        """Whether anything moves."""
        return bool(self._balls)

    @property
    def next_id(self) -> int:
        """The id that the next ball will have."""
        return self._next_id

    @property
    def count(self) -> int:
        """Number of live balls."""
        return len(self._balls)

    @property
    def balls(self) -> tuple[Ball, ...]:
        """The live balls' origins, in the order of `bodies`."""
        return tuple(self._balls)

    def add(
        self,
        seed: int | str | None = None,
        *,
        x: float | None = None,
        aim: float | None = None,
    ) -> int:
        """Start a ball where `seed` says, around `aim`, or at an explicit `x`; return its id.

        x and aim are in m; without an aim seeds draw about the board's own x.
        """
        if seed is None and x is None:
            raise ParameterError("a ball needs a seed or an explicit x", field="seed")
        chosen = None if seed is None else parse_seed(seed)
        return self.add_at(start_of(self.board, chosen, unsigned_zero(x), aim), chosen)

    def add_at(self, start: float, seed: int | None) -> int:
        """`add` of a parsed `seed` with its `start` in m, which `start_of` has found valid."""
        ball = Ball(self._next_id, seed, start, self.tick)
        self._ball_set.add(ball.x)
        self._next_id += 1
        self._balls.append(ball)
        self._bounced = np.append(self._bounced, np.uint8(0))
        self._previous = np.vstack([self._previous, self._ball_set.states[-1]])
        return ball.id

    def add_late(self, start: float, seed: int | None, tick: int) -> int:
        """`add_at` of a ball that began at an earlier tick: it is where it would be by now.

        If it has landed since, `take_events` tells so, with the tick at which it did. For worlds of
        the exact solver, in which a ball's path depends on nothing else.
        """
        alone = World(self.board, dt=self.dt)
        alone.tick, alone._next_id = tick, self._next_id
        alone.add_at(start, seed)
        while alone.tick < self.tick:
            alone.step(contacts=False)
        self._next_id += 1
        self._events += alone.take_events()
        if alone._balls:
            self._exact().add_at(start, self.tick - tick)
            self._balls += alone._balls
            self._bounced = np.append(self._bounced, np.uint8(0))
            self._previous = np.vstack([self._previous, self._ball_set.states[-1]])
        return self._next_id - 1

    def trajectory(self, ball: int) -> Trajectory:
        """The whole motion of a live ball, its future included; times count from its start.

        It is followed to its end, which takes as long as `drop`. Raises ParameterError for a ball
        that is not live, and in a world of the stepped solver, whose balls have no path before
        they have gone it.
        """
        return self._exact().whole(self._row(ball))

    def ahead(self, ball: int) -> tuple[int, Trajectory]:
        """What is known by now of a live ball's path, from where it is on.

        Returns how many segments of the path lie before those of the trajectory, whose end is
        where the ball is when what is known ends. Raises what `trajectory` raises.
        """
        return self._exact().ahead(self._row(ball))

    @property
    def known(self) -> list[float]:
        """Time in s since its start before which each live ball's path is known."""
        return self._exact().known

    @property
    def events_kept(self) -> int:
        """Events that are kept of the live balls: 56 bytes each, beside the segments of paths."""
        return self._ball_set.events if isinstance(self._ball_set, ExactBalls) else 0

    @property
    def prepared(self) -> bool:
        """Whether all is made of the board that is needed to follow the balls there are."""
        return self._ball_set.prepared

    def prepare(self) -> None:
        """Make it, on any thread: some 6 ms of a board of 5,000 pegs, made for its first ball.

        `step` does by itself what was not done before.
        """
        self._ball_set.prepare()

    @property
    def ready(self) -> bool:
        """Whether the next step takes no more than moving the balls along what is known."""
        return self._ball_set.ready

    def look_ahead(self) -> bool:
        """Follow some ball's path for some events more; whether there is more that would help.

        It changes nothing of what happens, only when it is computed. `step` does by itself what
        was not done before.
        """
        return self._ball_set.look_ahead()

    def _exact(self) -> ExactBalls:
        if not isinstance(self._ball_set, ExactBalls):
            raise ParameterError("a stepped world knows no ball's path", field="solver")
        return self._ball_set

    def has(self, ball: int) -> bool:
        """Whether this ball is in flight."""
        return any(live.id == ball for live in self._balls)

    def _row(self, ball: int) -> int:
        for row, live in enumerate(self._balls):
            if live.id == ball:
                return row
        raise ParameterError(f"ball {ball} is not in flight", field="ball")

    def step(self, *, contacts: bool = True) -> None:
        """Advance by one step; without `contacts`, `take_events` returns only landings."""
        self.tick += 1
        if not self._balls:
            return
        self._previous = self._ball_set.states.copy()
        self._bounced[:] = 0
        ended = []
        news: list[tuple[tuple[float, int, int], Event]] = []
        for progress in self._ball_set.step():
            ball = self._balls[progress.row]
            self._bounced[progress.row] = (progress.marks[:, 0] <= KIND_WALL).any()
            if contacts:
                news += self._contacts(ball, progress)
            if progress.end is not None:
                ended.append(progress.row)
                news.append(self._landing(ball, progress))
        news.sort(key=lambda item: item[0])
        self._events += [event for _, event in news]
        if ended:
            self._remove(ended)

    def _contacts(
        self, ball: Ball, progress: Progress
    ) -> list[tuple[tuple[float, int, int], Event]]:
        """Contacts with their place in the total order: time in the world, kind, ball."""
        found: list[tuple[tuple[float, int, int], Event]] = []
        for row, (kind, index) in zip(
            progress.events.tolist(), progress.marks.tolist(), strict=True
        ):
            if kind > KIND_WALL:
                continue
            speed = approach_speed(self.board, kind, index, tuple(row[1:5]))
            contact = Contact(ball.id, row[0], row[1], row[2], kind, index, speed)
            found.append(((ball.tick * self.dt + row[0], kind, ball.id), contact))
        return found

    def _landing(self, ball: Ball, progress: Progress) -> tuple[tuple[float, int, int], Event]:
        end = progress.end
        assert end is not None
        landed = end.outcome == LANDED
        landing = Landing(
            ball=ball.id,
            seed=ball.seed,
            tick=self.tick,
            t=end.t,
            x_end=end.x,
            bin=end.bin if landed else None,
            score=self.board.bins.multipliers[end.bin] if landed else 1.0,
            digest=end.digest,
            unsettled=None if landed else REASONS[end.outcome],
        )
        return (ball.tick * self.dt + end.t, KIND_WALL + 1, ball.id), landing

    def _remove(self, rows: list[int]) -> None:
        self._ball_set.remove(rows)
        self._balls = [ball for row, ball in enumerate(self._balls) if row not in rows]
        self._bounced = np.delete(self._bounced, rows)
        self._previous = np.delete(self._previous, rows, axis=0)

    def advance(self, frame_time: float) -> float:
        """Advance by `frame_time` seconds in whole steps; return alpha in [0, 1), the part left.

        The accumulator of a fixed time step: what does not fill a step is kept for the next call.
        """
        if not (isfinite(frame_time) and frame_time >= 0.0):
            raise ParameterError(
                f"frame_time {frame_time!r} is not a finite number of seconds >= 0",
                field="frame_time",
            )
        self._accumulator += frame_time
        while self._accumulator >= self.dt:
            self.step()
            self._accumulator -= self.dt
        return self._accumulator / self.dt

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        """The live balls at the current tick, shape (count,), dtype BODY."""
        return self._as_bodies(self._ball_set.states)

    def interpolated(self, alpha: float) -> npt.NDArray[np.void]:
        """The live balls between the previous tick (alpha 0) and this one (1), linearly."""
        alpha = number(alpha, "alpha", 0.0, 1.0)
        return self._as_bodies(self._previous * (1.0 - alpha) + self._ball_set.states * alpha)

    def _as_bodies(self, states: npt.NDArray[np.float64]) -> npt.NDArray[np.void]:
        rows = np.empty(len(states), BODY)
        rows["id"] = [ball.id for ball in self._balls]
        for name, column in _COLUMNS.items():
            rows[name] = states[:, column]
        rows["bounced"] = self._bounced
        return rows

    def take_events(self) -> list[Event]:
        """Contacts and landings since the last call, in order of time, then kind, then ball."""
        events, self._events = self._events, []
        return events

    def energy(self) -> Energy:
        """Energy of all live balls."""
        return energy_of(self.board, self._ball_set.states)

    def momentum(self) -> Momentum:
        """Momentum of all live balls."""
        return momentum_of(self.board.ball, self._ball_set.states)

    def snapshot(self) -> bytes:
        """Everything that `restore` needs to continue bit for bit, except events not yet taken.

        The names of its parts belong to `digest`, which is in the logs of rooms: they stay.
        """
        return msgspec.msgpack.encode(
            {
                "physics_version": PHYSICS_VERSION,
                "board_digest": self.board.digest,
                "solver": self.solver.encoded(),
                "dt": self.dt,
                "tick": self.tick,
                "accumulator": self._accumulator,
                "next_id": self._next_id,
                "balls": [(b.id, _decimal(b.seed), b.x, b.tick) for b in self._balls],
                "bounced": self._bounced.tobytes(),
                "previous": self._previous.astype("<f8").tobytes(),
                "crowd": self._ball_set.saved(),
            }
        )

    def restore(self, snapshot: bytes) -> None:
        """Become the world that made `snapshot`: same board, solver and step, or RecordError."""
        saved = self._checked(snapshot)
        self.tick = saved["tick"]
        self._accumulator = saved["accumulator"]
        self._next_id = saved["next_id"]
        self._balls = [
            Ball(number, None if seed is None else int(seed), x, tick)
            for number, seed, x, tick in saved["balls"]
        ]
        self._bounced = np.frombuffer(saved["bounced"], np.uint8).copy()
        self._previous = np.frombuffer(saved["previous"], "<f8").reshape(-1, 7).copy()
        self._events = []
        self._ball_set = self._new_ball_set()
        self._ball_set.load(saved["crowd"])

    def _checked(self, snapshot: bytes) -> dict[str, Any]:
        try:
            saved = msgspec.msgpack.decode(snapshot, type=dict[str, Any])
        except msgspec.MsgspecError as error:
            raise RecordError(f"the snapshot is not one: {error}", field="snapshot") from error
        mine = {
            "physics_version": PHYSICS_VERSION,
            "board_digest": self.board.digest,
            "solver": self.solver.encoded(),
            "dt": self.dt,
        }
        for name, value in mine.items():
            if saved.get(name) != value:
                raise RecordError(f"the snapshot is of a world with another {name}", field=name)
        return saved

    def digest(self) -> str:
        """SHA-256 of the snapshot, 64 hex digits: equal worlds have equal digests."""
        return hashlib.sha256(self.snapshot()).hexdigest()


def _decimal(seed: int | None) -> str | None:
    """A seed as text: MessagePack has room for all of them, but not every reader has."""
    return None if seed is None else str(seed)
