"""`World`: a board with balls that advances in fixed steps; a live room ticks one."""

import hashlib
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.constants import KIND_WALL, PHYSICS_VERSION
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.start import start_of, unsigned_zero
from plinko.engine.drops.trajectory import Trajectory
from plinko.engine.errors import ParameterError, RecordError
from plinko.engine.exact.outcome import LANDED, REASONS
from plinko.engine.parameters import (
    DEFAULT_DT,
    SolverName,
    Stepped,
    frame_seconds,
    make_solver,
    number,
)
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats
from plinko.engine.seeding import parse_seed
from plinko.engine.world.events import Contact, End, Event, Landing, Progress, approach_speed
from plinko.engine.world.exact_balls import ExactBalls
from plinko.engine.world.stepped_balls import SteppedBalls

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
    """The origin of a ball: its seed, the x of its start in m, and the tick of its start."""

    id: int
    seed: int | None
    x: float
    tick: int


@dataclass(frozen=True, slots=True)
class Energy:
    """Energies of all live balls in J; the potential energy is zero at y = 0."""

    kinetic: float
    rotational: float
    potential: float

    @property
    def total(self) -> float:
        """Sum of the three."""
        return self.kinetic + self.rotational + self.potential


@dataclass(frozen=True, slots=True)
class Momentum:
    """Momentum of all live balls in kg m/s, and angular momentum about the origin in kg m^2/s."""

    x: float
    y: float
    angular: float


class World:
    """Balls on a board, advanced in steps of dt seconds by one of the two solvers.

    A ball starts at the tick at which it is added and leaves the world when its drop ends. With the
    exact solver, dt only decides when states are sampled: each ball's path is that of `drop`.
    Balls pass through each other, unlike those of `Arena`. board: a Board, or a preset's name.
    """

    def __init__(
        self,
        board: Board | str,
        *,
        solver: SolverName = "exact",
        dt: float = DEFAULT_DT,
        substeps: int | None = None,
        correction: float | None = None,
    ) -> None:
        self.board = board = Board.named(board)
        self.dt = number(dt, "dt", 1e-6, 0.1)
        step = None if solver == "exact" else self.dt
        self.solver = make_solver(solver, step, substeps, correction)
        self.tick = 0
        self._accumulator = 0.0
        self._next_id = 0
        self._balls: list[Ball] = []
        self._bounced = np.zeros(0, np.uint8)
        self._previous = np.zeros((0, 7))
        self._events: list[Event] = []
        self._ball_set = self._new_ball_set()

    def _new_ball_set(self) -> ExactBalls | SteppedBalls:
        if isinstance(self.solver, Stepped):
            return SteppedBalls(self.board, self.solver)
        return ExactBalls(self.board, self.dt)

    @property
    def time(self) -> float:
        """Seconds since the world began."""
        return self.tick * self.dt

    @property
    def awake(self) -> bool:
        """Whether any ball is in flight."""
        return bool(self._balls)

    @property
    def count(self) -> int:
        """Number of balls in flight."""
        return len(self._balls)

    def add(
        self,
        seed: int | str | None = None,
        *,
        x: float | None = None,
        aim: float | None = None,
    ) -> int:
        """Start a ball where `seed` draws it, or at an explicit `x` in m; return its id.

        aim: the middle in m of the starts that seeds draw (default: the board's own).
        """
        if seed is None and x is None:
            raise ParameterError("a ball needs a seed or an explicit x", field="seed")
        chosen = None if seed is None else parse_seed(seed)
        start = start_of(self.board, chosen, unsigned_zero(x), aim)
        self._ball_set.add(start)
        ball = Ball(self._next_id, chosen, start, self.tick)
        return self._enter(ball, self._ball_set.states[-1])

    def _enter(self, ball: Ball, before: Floats) -> int:
        """Note a ball that the ball set has, and its state one step ago; return its id."""
        self._next_id = ball.id + 1
        self._balls.append(ball)
        self._bounced = np.append(self._bounced, np.uint8(0))
        self._previous = np.vstack([self._previous, before])
        return ball.id

    def add_flight(
        self, flight: Flight, seed: int | None, tick: int, ball_id: int | None = None
    ) -> int:
        """Add a ball that started at `tick`, now or earlier, with its computed flight.

        The world is then as if the ball had been added at that tick. If it has landed since,
        `take_events` returns the landing. `ball_id` may leave out ids of balls that have landed.
        Only for the exact solver; return the ball's id.
        """
        ball = Ball(self._next_id if ball_id is None else ball_id, seed, flight.x_start, tick)
        before, progress = self._exact().add_flight(flight, self.tick - tick)
        self._enter(ball, before)
        if progress is not None:
            self._news([progress], contacts=False)
        return ball.id

    def trajectory(self, ball: int) -> Trajectory:
        """The whole trajectory of a live ball, including its future; times count from its start.

        Raises ParameterError for a ball that is not in flight, and in a world of the stepped
        solver, which cannot compute paths ahead.
        """
        return self._exact().whole(self._row(ball))

    @property
    def events_kept(self) -> int:
        """Number of the live balls' events in memory, 56 bytes each."""
        return self._ball_set.events if isinstance(self._ball_set, ExactBalls) else 0

    def _exact(self) -> ExactBalls:
        if not isinstance(self._ball_set, ExactBalls):
            raise ParameterError(
                "solver is 'stepped', which cannot compute a ball's path ahead: use 'exact'",
                field="solver",
            )
        return self._ball_set

    def _row(self, ball: int) -> int:
        for row, live in enumerate(self._balls):
            if live.id == ball:
                return row
        raise ParameterError(
            f"ball {ball} is not in flight: it has ended, or was never added", field="ball"
        )

    def step(self, *, contacts: bool = True) -> None:
        """Advance by one step; without `contacts`, `take_events` returns only landings."""
        self.tick += 1
        if not self._balls:
            return
        self._previous = self._ball_set.states.copy()
        self._bounced[:] = 0
        self._news(self._ball_set.step(), contacts=contacts)

    def advance_to(self, tick: int, *, contacts: bool = True) -> None:
        """Advance to a later tick; with the exact solver this takes no longer than two steps.

        Of the contacts, only those of the last step become events.
        """
        if isinstance(self._ball_set, ExactBalls) and self._balls and tick > self.tick + 1:
            skipped = tick - 1 - self.tick
            self.tick += skipped
            self._news(self._ball_set.step(skipped), contacts=False)
        if not self._balls:
            self.tick = max(self.tick, tick)
        while self.tick < tick:
            self.step(contacts=contacts)

    def _news(self, progresses: list[Progress], *, contacts: bool) -> None:
        """Note the balls' events, and remove those whose drop has ended."""
        ended = []
        news: list[tuple[tuple[float, int, int], Event]] = []
        for progress in progresses:
            ball = self._balls[progress.row]
            self._bounced[progress.row] = (progress.impacts["kind"] <= KIND_WALL).any()
            if contacts:
                news += self._contacts(ball, progress)
            if progress.end is not None:
                ended.append(progress.row)
                news.append(self._landing(ball, progress.end))
        news.sort(key=lambda item: item[0])
        self._events += [event for _, event in news]
        if ended:
            self._remove(ended)

    def _contacts(
        self, ball: Ball, progress: Progress
    ) -> list[tuple[tuple[float, int, int], Event]]:
        """Contacts, each with its sort key: time in the world, kind, ball."""
        found: list[tuple[tuple[float, int, int], Event]] = []
        for t, x, y, vx, vy, _, kind, index in progress.impacts.tolist():
            if kind > KIND_WALL:
                continue
            speed = approach_speed(self.board, kind, index, (x, y, vx, vy))
            contact = Contact(ball.id, t, x, y, kind, index, speed)
            found.append(((ball.tick * self.dt + t, kind, ball.id), contact))
        return found

    def _landing(self, ball: Ball, end: End) -> tuple[tuple[float, int, int], Event]:
        where = end.bin if end.outcome == LANDED else None
        landing = Landing(
            ball=ball.id,
            seed=ball.seed,
            tick=self.tick if end.ticks is None else ball.tick + end.ticks,
            t=end.t,
            x_end=end.x,
            bin=where,
            score=self.board.bins.score_of(where),
            digest=end.digest,
            unsettled=REASONS[end.outcome] or None,
        )
        return (ball.tick * self.dt + end.t, KIND_WALL + 1, ball.id), landing

    def _remove(self, rows: list[int]) -> None:
        self._ball_set.remove(rows)
        self._balls = [ball for row, ball in enumerate(self._balls) if row not in rows]
        self._bounced = np.delete(self._bounced, rows)
        self._previous = np.delete(self._previous, rows, axis=0)

    def advance(self, frame_time: float) -> float:
        """Advance by `frame_time` seconds in whole steps; return the rest in steps, in [0, 1).

        This is the accumulator of a fixed time step: the next call begins with the rest, which is
        also the alpha for `interpolated`. Raises ParameterError for more than MOST_STEPS steps.
        """
        self._accumulator += frame_seconds(frame_time, self.dt)
        while self._accumulator >= self.dt:
            self.step()
            self._accumulator -= self.dt
        return self._accumulator / self.dt

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        """The live balls at the current tick, shape (count,), dtype BODY."""
        return self._as_bodies(self._ball_set.states)

    def interpolated(self, alpha: float) -> npt.NDArray[np.void]:
        """The live balls, interpolated linearly between the previous tick (0) and this one (1)."""
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
        ball, states = self.board.ball, self._ball_set.states
        speed2 = float((states[:, body.VX] ** 2 + states[:, body.VY] ** 2).sum())
        return Energy(
            kinetic=0.5 * ball.mass * speed2,
            rotational=0.5 * ball.inertia * float((states[:, body.OMEGA] ** 2).sum()),
            potential=-ball.mass * self.board.gravity * float(states[:, body.Y].sum()),
        )

    def momentum(self) -> Momentum:
        """Momentum of all live balls."""
        ball, states = self.board.ball, self._ball_set.states
        turning = states[:, body.X] * states[:, body.VY] - states[:, body.Y] * states[:, body.VX]
        return Momentum(
            x=ball.mass * float(states[:, body.VX].sum()),
            y=ball.mass * float(states[:, body.VY].sum()),
            angular=float(ball.mass * turning.sum() + ball.inertia * states[:, body.OMEGA].sum()),
        )

    def snapshot(self) -> bytes:
        """Everything that `restore` needs to continue bit for bit, except events not yet taken.

        The keys must never change: `digest` covers them, and rooms' logs contain digests.
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
        """Continue from `snapshot`; RecordError unless it is of the same board, solver and dt."""
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
            raise RecordError(f"the snapshot is malformed: {error}", field="snapshot") from error
        mine = {
            "physics_version": PHYSICS_VERSION,
            "board_digest": self.board.digest,
            "solver": self.solver.encoded(),
            "dt": self.dt,
        }
        for name, value in mine.items():
            if saved.get(name) != value:
                raise RecordError(
                    f"the snapshot is from a world with another {name}: restore it into an equal "
                    "world",
                    field=name,
                )
        return saved

    @property
    def digest(self) -> str:
        """SHA-256 of the snapshot, 64 hex digits: equal worlds have equal digests."""
        return hashlib.sha256(self.snapshot()).hexdigest()

    def skip_ids(self, next_id: int) -> None:
        """Give the next ball this id, because those before it have landed."""
        self._next_id = max(self._next_id, next_id)


def _decimal(seed: int | None) -> str | None:
    """A seed as text, because not every MessagePack reader can represent 64-bit integers."""
    return None if seed is None else str(seed)
