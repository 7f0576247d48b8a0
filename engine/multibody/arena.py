"""Balls that touch each other, on any board or in a box: what a sandbox or a live room ticks.

An arena is a place, settings, and balls that are added, removed, kicked and edited while it runs.
These are its inputs: the same ones at the same ticks give the same bits, on every run and machine.
"""

import hashlib
from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from engine.constants import PHYSICS_VERSION
from engine.errors import ParameterError, RecordError
from engine.multibody.bodies import RANGES, BallTable, checked
from engine.multibody.diagnostics import Diagnostics, diagnose
from engine.multibody.events import (
    KEPT_FRAMES,
    ArenaEvent,
    Landed,
    Left,
    Told,
    Touch,
    new_log,
    told_of,
    touches_of,
)
from engine.multibody.settings import ArenaSettings
from engine.multibody.solver.layout import (
    ARC,
    ASLEEP,
    AWAKE_THEN,
    BOUNCED,
    DEPARTURES,
    FLAGS,
    FRICTION,
    GONE,
    ID,
    INVERSE_MASS,
    LANDED,
    LANDINGS,
    LEFT,
    RADIUS,
    RESTITUTION,
    ROLL,
    TOUCHES,
    VX,
    VY,
    X,
    Y,
)
from engine.multibody.solver.step import frame
from engine.multibody.static_geometry import Place, statics_of
from engine.parameters import number

ARENA_BODY = np.dtype(
    [("id", "<i4")]
    + [(name, "<f8") for name in ("x", "y", "theta", "vx", "vy", "omega", "radius")]
    + [("asleep", "u1"), ("bounced", "u1")]
)
"""A ball: id, m, rad, m/s, rad/s, m; whether it sleeps, and had an impact in the last frame."""

DEFAULTS: Mapping[str, float] = {
    "theta": 0.0,
    "vx": 0.0,
    "vy": 0.0,
    "omega": 0.0,
    "radius": 0.08,
    "density": 80.0,
    "restitution": 0.6,
    "friction": 0.2,
}

INPUTS = (
    "add", "add_many", "remove", "remove_many", "clear",
    "kick", "impulse", "edit", "edit_all", "wake_all", "configure",
)  # fmt: skip
"""The methods that change an arena, besides `step`."""


class Arena:
    """Balls that touch each other, advanced in frames of settings.dt seconds.

    `record`: set to a list, it collects all inputs as JSON values; `replay` does them again.
    """

    def __init__(self, place: Place, settings: ArenaSettings | None = None) -> None:
        self.place = place
        self.settings = settings or ArenaSettings()
        self.tick = 0
        self.time = 0.0
        """Seconds of the arena: the sum of its frames."""
        self.events_lost = 0
        """Impacts that were not told: too many in a frame, or not asked for in time."""
        self.record: list[dict[str, Any]] | None = None
        self._statics = statics_of(place)
        self._compiled = self.settings.compiled()
        self._table = BallTable()
        self._next_id = 0
        self._accumulator = 0.0
        self._previous = np.zeros((0, 3))
        self._rests = False
        """Whether a frame has found all asleep; true as long as the table is listed."""
        self._log = new_log(0)
        self._told: list[tuple[int, float, Told]] = []
        self._ends: list[Landed | Left] = []

    # Inputs

    def _noted(self, op: str, **arguments: Any) -> None:
        if self.record is not None:
            self.record.append({"op": op, "tick": self.tick, **arguments})

    def apply(self, entry: Mapping[str, Any]) -> Any:
        """Do one recorded input: `op` is its name, the rest are its arguments (`tick` is not read).

        ParameterError if there is no such input, or its arguments are wrong.
        """
        op = entry.get("op")
        if op not in INPUTS:
            raise ParameterError(f"op {op!r:.40} is none of {', '.join(INPUTS)}", field="op")
        arguments = {key: value for key, value in entry.items() if key not in {"op", "tick"}}
        try:
            return getattr(self, str(op))(**arguments)
        except TypeError as error:
            raise ParameterError(f"arguments of {op}: {error}", field="op") from error

    def add(self, x: float, y: float, **values: float) -> int:
        """Add a ball at (x, y) in m and return its id; values as in DEFAULTS."""
        arrays: dict[str, Any] = {name: [value] for name, value in values.items()}
        return self.add_many([x], [y], **arrays)[0]

    def add_many(
        self,
        x: npt.ArrayLike,
        y: npt.ArrayLike,
        *,
        ids: Iterable[int] | None = None,
        **values: npt.ArrayLike,
    ) -> list[int]:
        """Add balls and return their ids. Each value is a list or one for all.

        ids: by default the next numbers. What happens depends on the ids and not on the order in
        which balls are added.
        """
        unknown = set(values) - set(DEFAULTS)
        if unknown:
            raise ParameterError(f"a ball has no {sorted(unknown)[0]!r}", field=min(unknown))
        found = {name: checked(name, value) for name, value in values.items()}
        found |= {"x": checked("x", x), "y": checked("y", y)}
        count = max(len(array) for array in found.values())
        for name, array in found.items():
            if len(array) not in {1, count}:
                raise ParameterError(f"{len(array)} {name} for {count} balls", field=name)
        complete = {
            name: np.broadcast_to(found.get(name, np.array([DEFAULTS.get(name, 0.0)])), count)
            for name in RANGES
        }
        chosen = self._new_ids(count, ids)
        order = np.argsort(chosen, kind="stable")
        self._table.append(chosen[order], {name: v[order] for name, v in complete.items()})
        self._previous = self._table.bodies.pos[: self.count, :3].copy()
        self._next_id = max(self._next_id, int(chosen.max()) + 1)
        if self.record is not None:
            lists = {name: array.tolist() for name, array in found.items()}
            self._noted("add_many", ids=chosen.tolist(), **lists)
        return [int(i) for i in chosen]

    def _new_ids(self, count: int, ids: Iterable[int] | None) -> npt.NDArray[np.int32]:
        if ids is None:
            return np.arange(self._next_id, self._next_id + count, dtype=np.int32)
        asked = list(ids)
        for i in asked:
            if type(i) is not int or not 0 <= i < 2**31 - 1:
                raise ParameterError(f"id {i!r:.40} is not from 0 to 2^31 - 2", field="ids")
        if len(asked) != count or len(set(asked)) != count:
            raise ParameterError(f"{len(set(asked))} ids for {count} balls", field="ids")
        chosen = np.array(asked, np.int32)
        taken = np.intersect1d(chosen, self._table.ids)
        if len(taken):
            raise ParameterError(f"there already is a ball {int(taken[0])}", field="ids")
        return chosen

    def remove(self, ball: int) -> None:
        """Take a ball out."""
        self.remove_many([ball])

    def remove_many(self, balls: Iterable[int]) -> None:
        """Take balls out; all must be there."""
        chosen = [int(ball) for ball in balls]
        rows = [self._table.row(ball) for ball in chosen]
        for row in rows:
            self._table.wake_with(row)
        self._drop(rows)
        self._noted("remove_many", balls=chosen)

    def clear(self) -> None:
        """Take all balls out."""
        self._table.wake_all()
        self._drop(list(range(self.count)))
        self._noted("clear")

    def _drop(self, rows: list[int]) -> None:
        kept = np.delete(np.arange(self.count), rows)
        self._previous = self._previous[kept]
        self._table.keep(kept)

    def kick(self, ball: int, dvx: float, dvy: float, domega: float = 0.0) -> None:
        """Change a ball's velocity, m/s, and its spin, rad/s."""
        row = self._table.row(ball)
        vel, radius = self._table.bodies.vel, self._table.bodies.pos[row, RADIUS]
        for name, value in (("vx", dvx), ("vy", dvy), ("omega", domega)):
            checked(name, value)
        self._table.wake_with(row)
        vel[row, VX] += dvx
        vel[row, VY] += dvy
        vel[row, ROLL] += domega * radius
        self._noted("kick", ball=int(ball), dvx=dvx, dvy=dvy, domega=domega)

    def impulse(self, ball: int, jx: float, jy: float) -> None:
        """Give a ball an impulse in N s."""
        row = self._table.row(ball)
        over = float(self._table.bodies.vel[row, INVERSE_MASS])
        checked("vx", jx * over)
        checked("vy", jy * over)
        self._table.wake_with(row)
        self._table.bodies.vel[row, VX] += jx * over
        self._table.bodies.vel[row, VY] += jy * over
        self._noted("impulse", ball=int(ball), jx=jx, jy=jy)

    def edit(self, ball: int, **values: float) -> None:
        """Set some of a ball's values, those of RANGES; at another radius it keeps its density."""
        row = self._table.row(ball)
        self._set(np.array([row]), values)
        self._noted("edit", ball=int(ball), **values)

    def edit_all(self, **values: float) -> None:
        """Set some values of all balls."""
        self._set(np.arange(self.count), values)
        self._noted("edit_all", **values)

    def _set(self, rows: npt.NDArray[np.intp], values: Mapping[str, float]) -> None:
        unknown = set(values) - set(RANGES)
        if unknown:
            raise ParameterError(f"a ball has no {sorted(unknown)[0]!r}", field=min(unknown))
        new = {name: float(checked(name, value)[0]) for name, value in values.items()}
        for row in rows.tolist():
            self._table.wake_with(row)
        pos, vel, surface, _, _ = self._table.bodies
        if "radius" in new:
            ratio = new["radius"] / pos[rows, RADIUS]
            pos[rows, ARC] *= ratio  # the angle and the spin stay
            vel[rows, ROLL] *= ratio
            vel[rows, INVERSE_MASS] /= ratio * ratio
            pos[rows, RADIUS] = new["radius"]
        radius = pos[rows, RADIUS]
        if "density" in new:
            vel[rows, INVERSE_MASS] = 1.0 / (new["density"] * (np.pi * radius * radius))
        for name, array, column in (
            ("x", pos, X), ("y", pos, Y), ("vx", vel, VX), ("vy", vel, VY),
            ("restitution", surface, RESTITUTION), ("friction", surface, FRICTION),
        ):  # fmt: skip
            if name in new:
                array[rows, column] = new[name]
        if "theta" in new:
            pos[rows, ARC] = new["theta"] * radius
        if "omega" in new:
            vel[rows, ROLL] = new["omega"] * radius
        self._table.is_listed = False

    def wake_all(self) -> None:
        """Wake all balls."""
        self._table.wake_all()
        self._noted("wake_all")

    def configure(self, **values: Any) -> None:
        """Change settings while it runs, those of ArenaSettings; all balls wake."""
        try:
            changed = ArenaSettings(**(self.settings.to_dict() | values))
        except TypeError as error:
            raise ParameterError(f"settings: {error}", field="settings") from error
        self.settings, self._compiled = changed, changed.compiled()
        self._table.wake_all()
        self._noted("configure", **values)

    # Time

    @property
    def count(self) -> int:
        """Number of balls."""
        return self._table.n

    @property
    def awake(self) -> bool:
        """Whether anything moves; if not, a step changes nothing but the tick."""
        marks = self._table.bodies.marks[: self.count, FLAGS]
        return bool((marks & ASLEEP == 0).any())

    def step(self) -> None:
        """Advance by one frame."""
        start = self.time
        self.tick += 1
        self.time = start + self.settings.dt
        table = self._table
        if table.n == 0 or (self._rests and table.is_listed):
            return
        self._previous = table.bodies.pos[: table.n].copy()
        if len(self._log.landed) <= table.n:
            self._log = new_log(table.n)
        table.pairs = frame(
            table.bodies, table.n, table.pairs, self._statics, self._compiled, self._log,
            table.is_listed,
        )  # fmt: skip
        counts = self._log.counts.tolist()
        self._rests = counts[AWAKE_THEN] == 0
        if not self._rests:
            table.is_listed = True
            self._collect(start, counts)

    def _collect(self, start: float, counts: list[int]) -> None:
        """Keep what the log tells, and take out the balls that landed or left."""
        log, table = self._log, self._table
        if counts[TOUCHES]:
            told = told_of(log, counts[TOUCHES])
            self.events_lost += counts[TOUCHES] - len(told.floats)
            self._told.append((self.tick, start, told))
            if len(self._told) > KEPT_FRAMES:
                self.events_lost += len(self._told.pop(0)[2].floats)
        landings = counts[LANDINGS]
        if not (landings or counts[DEPARTURES]):
            return
        flags = table.bodies.marks[: table.n, FLAGS]
        gone = np.flatnonzero(flags & GONE)
        times = {
            int(ball): (float(t), float(x))
            for ball, (t, x) in zip(log.landed[:landings], log.landings[:landings], strict=True)
        }
        for row in gone.tolist():
            ball = int(table.bodies.marks[row, ID])
            if flags[row] & LEFT or not flags[row] & LANDED:
                self._ends.append(Left(self.tick, self.time, ball))
            else:
                t, x = times[ball]
                self._ends.append(Landed(self.tick, start + t, ball, self._bin_of(x), x))
        self._drop(gone.tolist())

    def _bin_of(self, x: float) -> int:
        assert self.place.bins is not None
        inner = self.place.bins.edges[1:-1]
        return int(np.searchsorted(inner, x, side="right"))

    def advance(self, frame_time: float) -> float:
        """Advance by `frame_time` seconds in whole frames; return the part left, in [0, 1)."""
        if not (isfinite(frame_time) and frame_time >= 0.0):
            raise ParameterError(
                f"frame_time {frame_time!r} is not a finite number of seconds >= 0",
                field="frame_time",
            )
        self._accumulator += frame_time
        while self._accumulator >= self.settings.dt:
            self._accumulator -= self.settings.dt
            self.step()
        return self._accumulator / self.settings.dt

    # Reading

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        """All balls by ascending id, shape (count,), dtype ARENA_BODY; a copy."""
        return self._as_bodies(self._table.bodies.pos[: self.count])

    def interpolated(self, alpha: float) -> npt.NDArray[np.void]:
        """The balls between the previous tick (alpha 0) and this one (1), linearly."""
        alpha = number(alpha, "alpha", 0.0, 1.0)
        now = self._table.bodies.pos[: self.count]
        between = now.copy()
        between[:, :3] = self._previous[:, :3] * (1.0 - alpha) + now[:, :3] * alpha
        return self._as_bodies(between)

    def _as_bodies(self, pos: npt.NDArray[np.float64]) -> npt.NDArray[np.void]:
        n = self.count
        vel, marks = self._table.bodies.vel[:n], self._table.bodies.marks[:n]
        rows = np.empty(n, ARENA_BODY)
        rows["id"] = marks[:, ID]
        rows["x"], rows["y"], rows["radius"] = pos[:, X], pos[:, Y], pos[:, RADIUS]
        rows["theta"] = pos[:, ARC] / pos[:, RADIUS]
        rows["vx"], rows["vy"] = vel[:, VX], vel[:, VY]
        rows["omega"] = vel[:, ROLL] / pos[:, RADIUS]
        rows["asleep"] = marks[:, FLAGS] & ASLEEP != 0
        rows["bounced"] = marks[:, FLAGS] & BOUNCED != 0
        return rows

    def ball(self, ball: int) -> dict[str, float]:
        """All values of one ball, those of RANGES, and its mass in kg."""
        row = self._table.row(ball)
        pos, vel, surface, _, _ = self._table.bodies
        radius = float(pos[row, RADIUS])
        mass = 1.0 / float(vel[row, INVERSE_MASS])
        return {
            "x": float(pos[row, X]),
            "y": float(pos[row, Y]),
            "theta": float(pos[row, ARC]) / radius,
            "vx": float(vel[row, VX]),
            "vy": float(vel[row, VY]),
            "omega": float(vel[row, ROLL]) / radius,
            "radius": radius,
            "density": mass / (np.pi * radius * radius),
            "restitution": float(surface[row, RESTITUTION]),
            "friction": float(surface[row, FRICTION]),
            "mass": mass,
        }

    def find(self, x: float, y: float) -> int | None:
        """Id of the ball under the point (x, y) in m, the nearest centre first; None if none is."""
        pos = self._table.bodies.pos[: self.count]
        squares = (pos[:, X] - x) ** 2 + (pos[:, Y] - y) ** 2
        under = np.flatnonzero(squares <= pos[:, RADIUS] ** 2)
        if len(under) == 0:
            return None
        return int(self._table.ids[under[np.argmin(squares[under])]])

    def take_events(self) -> list[ArenaEvent]:
        """Impacts, landings and balls that left since the last call, in order of time."""
        found: list[ArenaEvent] = []
        for tick, start, told in self._told:
            found += touches_of(told, tick, start, self._statics.peg_count)
        self._told = []
        found += self.take_landings()
        found.sort(key=lambda event: (event.t, not isinstance(event, Touch)))
        return found

    def take_landings(self) -> list[Landed | Left]:
        """The landings, and balls that left, since the last call; impacts stay to be taken."""
        ends, self._ends = self._ends, []
        return sorted(ends, key=lambda event: (event.t, event.ball))

    def diagnostics(self) -> Diagnostics:
        """Energies, momenta, contacts, overlap; costs nothing unless called."""
        return diagnose(self._table, self._statics, self.settings.gravity)

    @property
    def nbytes(self) -> int:
        """Memory of the balls and of who may touch whom, room not in use included."""
        return self._table.nbytes

    # Saving

    def snapshot(self) -> bytes:
        """All that `restore` needs to go on bit for bit, but for events not yet taken."""
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
        """Become the arena that made `snapshot`, its place and settings included; RecordError."""
        saved = _decoded(snapshot)
        try:
            self.place = Place.from_dict(saved["place"])
            self.settings = ArenaSettings(**saved["settings"])
            self.tick, self.time = saved["tick"], saved["time"]
            self._accumulator, self._next_id = saved["accumulator"], saved["next_id"]
            self._table.load(saved["table"])
            self._previous = np.frombuffer(saved["previous"]).reshape(-1, 3).copy()
        except (KeyError, TypeError, ValueError) as error:
            raise RecordError(f"the snapshot lacks {error}", field="snapshot") from error
        self._statics = statics_of(self.place)
        self._compiled = self.settings.compiled()
        self._told, self._ends, self._rests = [], [], False

    @classmethod
    def from_snapshot(cls, snapshot: bytes) -> "Arena":
        """A new arena that goes on where `snapshot` was made."""
        arena = cls(Place())
        arena.restore(snapshot)
        return arena

    def digest(self) -> str:
        """SHA-256 of the snapshot, 64 hex digits: equal arenas have equal digests."""
        return hashlib.sha256(self.snapshot()).hexdigest()


def _decoded(snapshot: bytes) -> dict[str, Any]:
    try:
        saved = msgspec.msgpack.decode(snapshot, type=dict[str, Any])
    except msgspec.MsgspecError as error:
        raise RecordError(f"the snapshot is not one: {error}", field="snapshot") from error
    if saved.get("arena") != 1 or saved.get("physics_version") != PHYSICS_VERSION:
        raise RecordError("the snapshot is of no arena of this version", field="physics_version")
    return saved


def replay(
    place: Place, settings: ArenaSettings, inputs: Iterable[Mapping[str, Any]], ticks: int
) -> Arena:
    """A new arena with recorded inputs done at their ticks, advanced to the tick `ticks`."""
    arena = Arena(place, settings)
    for entry in inputs:
        while arena.tick < entry["tick"]:
            arena.step()
        arena.apply(entry)
    while arena.tick < ticks:
        arena.step()
    return arena
