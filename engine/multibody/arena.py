"""`Arena`: balls that touch each other, on a board or in a box; a sandbox or a live room ticks one.

An arena has static geometry, settings and balls. While it runs, inputs add, remove, kick and edit
balls and change settings. The same inputs at the same ticks give the same bits, in every run and on
every machine.
"""

import copy
import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import inf
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.errors import ParameterError, RecordError, shorten
from plinko.engine.multibody.bodies import DEFAULTS, RANGES, BallTable, check_names, one, several
from plinko.engine.multibody.diagnostics import Diagnostics, diagnose
from plinko.engine.multibody.events import ArenaEvent, EventQueue, Landed, Left, new_log
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.solver.layout import body, step_log
from plinko.engine.multibody.solver.step import step_balls
from plinko.engine.multibody.static_geometry import StaticGeometry, static_shapes
from plinko.engine.parameters import frame_seconds, number


class Arena:
    """Balls that touch each other, advanced in steps of settings.dt seconds.

    place: the static geometry.
    """

    def __init__(self, place: StaticGeometry, settings: ArenaSettings | None = None) -> None:
        self.place = place
        self.settings = settings or ArenaSettings()
        self.tick = 0
        self.time = 0.0
        """The arena's time in s: the sum of its steps."""
        self._statics = static_shapes(place)
        self._solver_settings = self.settings.for_solver()
        self._table = BallTable()
        self._next_id = 0
        self._accumulator = 0.0
        self._previous = np.zeros((0, 3))
        self._rests = False
        """Whether the last step found all balls asleep; valid only while `_table.is_listed`."""
        self._log = new_log(0)
        self._events = EventQueue()

    # Inputs

    def add(self, x: float, y: float, **values: float) -> int:
        """Add a ball at (x, y) in m and return its id; values as in DEFAULTS."""
        check_names(values, DEFAULTS)
        arrays: dict[str, Any] = {name: [one(name, value)] for name, value in values.items()}
        return self.add_many([one("x", x)], [one("y", y)], **arrays)[0]

    def add_many(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        *,
        ids: Iterable[int] | None = None,
        **values: npt.ArrayLike,
    ) -> list[int]:
        """Add balls and return their ids. Each value is a list, or one number for all balls.

        ids: default is the next free numbers. The motion depends on the ids, but not on the order
        in which balls are added.
        """
        check_names(values, DEFAULTS)
        given = {**values, "x": x, "y": y}
        found = {name: several(name, value) for name, value in given.items()}
        count = max(len(array) for array in found.values())
        for name, array in found.items():
            if len(array) not in {1, count}:
                raise ParameterError(
                    f"{name} has {len(array)} values for {count} balls: it must have {count}, or 1",
                    field=name,
                )
        complete = {
            name: np.broadcast_to(found.get(name, np.array([DEFAULTS.get(name, 0.0)])), count)
            for name in RANGES
        }
        chosen = self._new_ids(count, ids)
        order = np.argsort(chosen, kind="stable")
        self._table.append(chosen[order], {name: v[order] for name, v in complete.items()})
        self._previous = self._table.bodies.pos[: self.count, :3].copy()
        self._next_id = max(self._next_id, int(chosen.max()) + 1)
        return [int(i) for i in chosen]

    def _new_ids(self, count: int, ids: Iterable[int] | None) -> npt.NDArray[np.int32]:
        if ids is None:
            return np.arange(self._next_id, self._next_id + count, dtype=np.int32)
        asked = _listed(ids, "ids")
        for i in asked:
            if type(i) is not int or not 0 <= i < 2**31 - 1:
                raise ParameterError(f"id {shorten(i)} is not from 0 to 2^31 - 2", field="ids")
        if len(asked) != count or len(set(asked)) != count:
            raise ParameterError(
                f"ids has {len(set(asked))} different values for {count} balls: it must have "
                f"{count}",
                field="ids",
            )
        chosen = np.array(asked, np.int32)
        taken = np.intersect1d(chosen, self._table.ids)
        if len(taken):
            raise ParameterError(
                f"ids has {int(taken[0])}, which another ball has: use a new one", field="ids"
            )
        return chosen

    def remove(self, ball: int) -> None:
        """Remove a ball."""
        row = self._table.row(ball)
        self._table.wake_with(row)
        self._drop([row])

    def clear(self) -> None:
        """Remove all balls."""
        self._table.wake_all()
        self._drop(list(range(self.count)))

    def _drop(self, rows: list[int]) -> None:
        kept = np.delete(np.arange(self.count), rows)
        self._previous = self._previous[kept]
        self._table.keep(kept)

    def kick(self, ball: int, dvx: float, dvy: float, domega: float = 0.0) -> None:
        """Add to a ball's velocity, m/s, and to its spin, rad/s."""
        dvx, dvy, domega = one("vx", dvx), one("vy", dvy), one("omega", domega)
        self._accelerate(self._table.row(ball), dvx, dvy, domega)

    def impulse(self, ball: int, jx: float, jy: float) -> None:
        """Give a ball an impulse in N s."""
        row = self._table.row(ball)
        jx, jy = number(jx, "jx", -inf, inf), number(jy, "jy", -inf, inf)
        over = float(self._table.bodies.vel[row, body.INVERSE_MASS])
        self._accelerate(row, jx * over, jy * over, 0.0)

    def _accelerate(self, row: int, dvx: float, dvy: float, domega: float) -> None:
        """Add to a velocity and a spin; ParameterError if that leaves their ranges."""
        vel, radius = self._table.bodies.vel, float(self._table.bodies.pos[row, body.RADIUS])
        vx = one("vx", float(vel[row, body.VX]) + dvx)
        vy = one("vy", float(vel[row, body.VY]) + dvy)
        rim = float(vel[row, body.RIM_SPEED]) + domega * radius
        one("omega", rim / radius)
        self._table.wake_with(row)
        vel[row, body.VX], vel[row, body.VY], vel[row, body.RIM_SPEED] = vx, vy, rim

    def edit(self, ball: int, **values: float) -> None:
        """Set some of a ball's values; RANGES lists them. A new radius keeps the density."""
        row = self._table.row(ball)
        self._set(np.array([row]), values)

    def edit_all(self, **values: float) -> None:
        """Set some values of all balls, as `edit` does for one."""
        self._set(np.arange(self.count), values)

    def _set(self, rows: npt.NDArray[np.intp], values: Mapping[str, float]) -> None:
        check_names(values, RANGES)
        new = {name: one(name, value) for name, value in values.items()}
        self._table.edit(rows, new)

    def edit_place(
        self, *, restitution: float | None = None, friction: float | None = None
    ) -> None:
        """Set the restitution or friction of all pegs and walls."""
        given = {"restitution": restitution, "friction": friction}
        new = {name: value for name, value in given.items() if value is not None}
        place = self.place
        self.place = replace(
            place,
            peg_material=replace(place.peg_material, **new),
            wall_material=replace(place.wall_material, **new),
        )
        self._statics = static_shapes(self.place)
        self._table.wake_all()

    def set_material(
        self, *, restitution: float | None = None, friction: float | None = None
    ) -> None:
        """Set the restitution or friction of everything, so that each pair has that value.

        Balls that are added later have their own.
        """
        given = {"restitution": restitution, "friction": friction}
        self.edit_place(**given)  # first: its ranges are within those of balls
        self.edit_all(**{name: value for name, value in given.items() if value is not None})

    def wake_all(self) -> None:
        """Wake all balls."""
        self._table.wake_all()

    def configure(self, **values: Any) -> None:
        """Change some of the ArenaSettings, and wake all balls."""
        changed = self.settings.changed(values)
        self.settings, self._solver_settings = changed, changed.for_solver()
        self._table.wake_all()

    # Time

    @property
    def count(self) -> int:
        """Number of balls."""
        return self._table.n

    @property
    def awake(self) -> bool:
        """Whether any ball is awake; if not, a step only advances tick and time."""
        marks = self._table.bodies.marks[: self.count, body.FLAGS]
        return bool((marks & body.ASLEEP == 0).any())

    def step(self) -> None:
        """Advance by one step of `settings.dt` seconds."""
        start = self.time
        self.tick += 1
        self.time = start + self.settings.dt
        table = self._table
        if table.n == 0 or (self._rests and table.is_listed):
            return
        self._previous = table.bodies.pos[: table.n].copy()
        if len(self._log.landed) <= table.n:
            self._log = new_log(table.n)
        table.pairs = step_balls(
            table.bodies, table.n, table.pairs, self._statics, self._solver_settings, self._log,
            table.is_listed,
        )  # fmt: skip
        counts = self._log.counts.tolist()
        self._rests = counts[step_log.AWAKE_BEFORE] == 0
        if not self._rests:
            table.is_listed = True
            self._collect(start, counts)

    def _collect(self, start: float, counts: list[int]) -> None:
        """Queue the events of a step, and remove the balls that landed or left."""
        log, table = self._log, self._table
        if counts[step_log.TOUCHES]:
            self._events.add_touches(log, self.tick, start)
        landings = counts[step_log.LANDINGS]
        if not (landings or counts[step_log.DEPARTURES]):
            return
        flags = table.bodies.marks[: table.n, body.FLAGS]
        gone = np.flatnonzero(flags & body.GONE)
        times = {
            int(ball): (float(t), float(x))
            for ball, (t, x) in zip(log.landed[:landings], log.landings[:landings], strict=True)
        }
        for row in gone.tolist():
            ball = int(table.bodies.marks[row, body.ID])
            if flags[row] & body.LEFT or not flags[row] & body.LANDED:
                self._events.add_end(Left(self.tick, self.time, ball))
            else:
                t, x = times[ball]
                self._events.add_end(Landed(self.tick, start + t, ball, self._bin_of(x), x))
        self._drop(gone.tolist())

    def _bin_of(self, x: float) -> int:
        assert self.place.bins is not None
        inner = self.place.bins.edges[1:-1]
        return int(np.searchsorted(inner, x, side="right"))

    def advance(self, frame_time: float) -> float:
        """Advance by `frame_time` seconds in whole steps; return the rest in steps, in [0, 1).

        Raises ParameterError for more than MOST_STEPS steps.
        """
        self._accumulator += frame_seconds(frame_time, self.settings.dt)
        while self._accumulator >= self.settings.dt:
            self._accumulator -= self.settings.dt
            self.step()
        return self._accumulator / self.settings.dt

    # Reading

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        """All balls by ascending id, shape (count,), dtype ARENA_BODY; a copy."""
        return self._table.records(self._table.bodies.pos[: self.count])

    def interpolated(self, alpha: float) -> npt.NDArray[np.void]:
        """The balls, interpolated linearly between the previous tick (0) and this one (1)."""
        alpha = number(alpha, "alpha", 0.0, 1.0)
        now = self._table.bodies.pos[: self.count]
        between = now.copy()
        between[:, :3] = self._previous[:, :3] * (1.0 - alpha) + now[:, :3] * alpha
        return self._table.records(between)

    def ball(self, ball: int) -> dict[str, float]:
        """All values of a ball that RANGES lists, and its mass in kg."""
        return self._table.values(self._table.row(ball))

    def find(self, x: float, y: float) -> int | None:
        """Id of the ball at (x, y) in m, or None; of several, the one with the nearest centre."""
        pos = self._table.bodies.pos[: self.count]
        squares = (pos[:, body.X] - x) ** 2 + (pos[:, body.Y] - y) ** 2
        under = np.flatnonzero(squares <= pos[:, body.RADIUS] ** 2)
        if len(under) == 0:
            return None
        return int(self._table.ids[under[np.argmin(squares[under])]])

    def take_events(self) -> list[ArenaEvent]:
        """Impacts, landings and departures since the last call, in order of time."""
        return self._events.take(self._statics.peg_count)

    def take_landings(self) -> list[Landed | Left]:
        """Only the landings and departures since the last call; impacts stay in the queue."""
        return self._events.take_ends()

    @property
    def events_lost(self) -> int:
        """Impacts missing from `take_events`: too many in a step, or not taken in time."""
        return self._events.lost

    def diagnostics(self) -> Diagnostics:
        """Energies, momenta, contacts and overlap; computed only by this call."""
        return diagnose(self._table, self._statics, self._solver_settings)

    @property
    def nbytes(self) -> int:
        """Bytes of the balls' arrays and neighbour list, including unused room."""
        return self._table.nbytes

    # Saving

    def copy(self) -> "Arena":
        """A copy that continues from here bit for bit."""
        other = copy.copy(self)
        other._log = new_log(0)
        other._table, other._events = self._table.copy(), self._events.copy()
        return other

    def snapshot(self) -> bytes:
        """Everything that `restore` needs to continue bit for bit, except events not yet taken."""
        return msgspec.msgpack.encode(
            {
                "arena": 1,
                "physics_version": PHYSICS_VERSION,
                "place": self.place.to_dict(),
                "settings": self.settings.to_dict(),
                "tick": self.tick,
                "time": self.time,
                "accumulator": self._accumulator,
                "next_id": self._next_id,
                "previous": np.ascontiguousarray(self._previous[:, :3]).tobytes(),
                "table": self._table.saved(),
            }
        )

    def restore(self, snapshot: bytes) -> None:
        """Continue from `snapshot`, with its geometry and settings; RecordError if malformed."""
        saved = _decoded(snapshot)
        try:
            self.place = StaticGeometry.from_dict(saved["place"])
            self.settings = ArenaSettings(**saved["settings"])
            self.tick, self.time = saved["tick"], saved["time"]
            self._accumulator, self._next_id = saved["accumulator"], saved["next_id"]
            self._table.load(saved["table"])
            self._previous = np.frombuffer(saved["previous"]).reshape(-1, 3).copy()
        except (KeyError, TypeError, ValueError) as error:
            raise RecordError(f"the snapshot is malformed: {error!r}", field="snapshot") from error
        self._statics = static_shapes(self.place)
        self._solver_settings = self.settings.for_solver()
        self._rests = False
        self._events.drop()

    @classmethod
    def from_snapshot(cls, snapshot: bytes) -> "Arena":
        """A new arena that continues from `snapshot`."""
        arena = cls(StaticGeometry())
        arena.restore(snapshot)
        return arena

    @property
    def digest(self) -> str:
        """SHA-256 of the snapshot, 64 hex digits: equal arenas have equal digests."""
        return hashlib.sha256(self.snapshot()).hexdigest()


def _listed(balls: object, name: str) -> list[Any]:
    """The ids in `balls` as a list; ParameterError if that is no list of anything."""
    try:
        return list(balls)  # type: ignore[call-overload, no-any-return]
    except TypeError as error:
        message = f"{name} {shorten(balls)} is not a list of ids"
        raise ParameterError(message, field=name) from error


def _decoded(snapshot: bytes) -> dict[str, Any]:
    try:
        saved = msgspec.msgpack.decode(snapshot, type=dict[str, Any])
    except (msgspec.MsgspecError, TypeError) as error:
        raise RecordError(f"the snapshot is malformed: {error}", field="snapshot") from error
    if saved.get("arena") != 1 or saved.get("physics_version") != PHYSICS_VERSION:
        raise RecordError(
            f"the snapshot has physics_version {saved.get('physics_version')!r}: it must be an "
            f"arena's with {PHYSICS_VERSION}",
            field="physics_version",
        )
    return saved
