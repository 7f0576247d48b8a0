"""The arrays of an arena's balls, in rows by ascending id, and their neighbour list."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from plinko.engine.errors import ParameterError, shorten
from plinko.engine.multibody.solver.layout import body
from plinko.engine.multibody.solver.layout.array_types import Floats, Ints
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.pair import NeighbourList
from plinko.engine.multibody.solver.neighbour_list import select_pairs
from plinko.engine.parameters import number

MAX_BALLS = 1_000_000
_FIRST_ROOM = 16

RANGES: Mapping[str, tuple[float, float]] = {
    "x": (-1e6, 1e6),
    "y": (-1e6, 1e6),
    "theta": (-1e9, 1e9),
    "vx": (-1e7, 1e7),
    "vy": (-1e7, 1e7),
    "omega": (-1e9, 1e9),
    "radius": (1e-6, 1e4),
    "density": (1e-12, 1e12),
    "restitution": (0.0, 1.0),
    "friction": (0.0, 1e6),
}
"""Ranges of a ball's values in m, rad, m/s, rad/s, kg/m^2."""

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
"""Values of a new ball if the caller does not give them; same units."""

ARENA_BODY = np.dtype(
    [("id", "<i4")]
    + [(name, "<f8") for name in ("x", "y", "theta", "vx", "vy", "omega", "radius")]
    + [("asleep", "u1"), ("bounced", "u1")]
)
"""A ball: id, m, rad, m/s, rad/s, m; whether it sleeps; whether it had an impact in the last
step."""


def one(name: str, value: object) -> float:
    """Return `value` as a float in the range of `name`; ParameterError otherwise."""
    return number(value, name, *RANGES[name])


def several(name: str, values: object) -> Floats:
    """Return numbers, or one number, as an array in the range of `name`; ParameterError otherwise.

    Shape (n,).
    """
    if isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "fiu":
        found = values.astype(np.float64)
        low, high = RANGES[name]
        bad = ~((found >= low) & (found <= high))  # a NaN fails too
        if bad.any():
            one(name, float(found[bad][0]))
        return found
    if isinstance(values, list | tuple):
        return np.array([one(name, value) for value in values])
    return np.array([one(name, values)])


def check_names(values: Mapping[str, Any], known: Mapping[str, Any]) -> None:
    """Raise ParameterError if a name in `values` is not in `known`."""
    unknown = set(values) - set(known)
    if unknown:
        name = min(unknown)
        raise ParameterError(
            f"{shorten(name)} is not a value of a ball: use {', '.join(known)}", field=name
        )


def no_pairs(n: int) -> NeighbourList:
    """An empty neighbour list for n balls."""
    zeros = np.zeros(n + 1, np.int32)
    none = np.zeros(0, np.int32)
    return NeighbourList(
        zeros, none, np.zeros((0, 3)), zeros.copy(), none.copy(),
        zeros.copy(), none.copy(), np.zeros((0, 3)),
    )  # fmt: skip


class BallTable:
    """Rows of balls with room to grow; `n` rows are in use. A ball's row changes when others go."""

    def __init__(self) -> None:
        self.n = 0
        self.bodies = _room_for(_FIRST_ROOM)
        self.pairs = no_pairs(0)
        self.is_listed = False
        """Whether `pairs` is valid for the current balls; if not, only its impulses are used."""

    @property
    def ids(self) -> Ints:
        """Ids of the rows in use, ascending; a view."""
        return self.bodies.marks[: self.n, body.ID]

    def row(self, ball: object) -> int:
        """Row of the ball with this id; ParameterError if it does not exist."""
        if isinstance(ball, int | np.integer) and not isinstance(ball, bool):
            row = int(np.searchsorted(self.ids, min(max(ball, -1), 2**31 - 1)))
            if row < self.n and self.ids[row] == ball:
                return row
        raise ParameterError(f"there is no ball {shorten(ball)}", field="id")

    def append(self, ids: Ints, values: Mapping[str, Floats]) -> None:
        """Add balls; ids: new and ascending; values: an array of that length for each of RANGES."""
        count, first = len(ids), self.n
        self._reserve(first + count)
        rows = slice(first, first + count)
        radius = values["radius"]
        pos, vel, surface, _, marks = self.bodies
        pos[rows, body.X], pos[rows, body.Y] = values["x"], values["y"]
        pos[rows, body.RIM_ARC], pos[rows, body.RADIUS] = values["theta"] * radius, radius
        vel[rows, body.VX], vel[rows, body.VY] = values["vx"], values["vy"]
        vel[rows, body.RIM_SPEED] = values["omega"] * radius
        vel[rows, body.INVERSE_MASS] = 1.0 / (values["density"] * (math.pi * radius * radius))
        surface[rows, body.RESTITUTION] = values["restitution"]
        surface[rows, body.FRICTION] = values["friction"]
        marks[rows] = 0
        marks[rows, body.ID] = ids
        marks[rows, body.NEXT_IN_ISLAND] = np.arange(first, first + count)
        self.n += count
        old = self.pairs
        more = {
            name: np.concatenate([starts, np.full(count, starts[-1], np.int32)])
            for name, starts in (("starts", old.starts), ("held_starts", old.held_starts))
        }
        self.pairs = old._replace(**more)
        self.is_listed = False
        if first and ids[0] < self.ids[first - 1]:
            self.keep(np.argsort(self.ids, kind="stable"))

    def _reserve(self, count: int) -> None:
        room = len(self.bodies.marks)
        if count <= room:
            return
        if count > MAX_BALLS:
            raise ParameterError(
                f"{count} balls are too many: at most {MAX_BALLS} are allowed", field="count"
            )
        new = _room_for(max(count, room + room // 4))
        for name in Bodies._fields:
            mine, old = getattr(new, name), getattr(self.bodies, name)
            mine[: self.n] = old[: self.n]
        self.bodies = new

    def keep(self, rows: npt.NDArray[np.intp]) -> None:
        """Keep only these rows, in this order, and the impulses between them.

        A sleeping island must be kept or removed as a whole; otherwise wake it first (`wake_with`).
        """
        target = np.full(self.n, -1, np.int32)
        target[rows] = np.arange(len(rows))
        for name in Bodies._fields:
            array = getattr(self.bodies, name)
            array[: len(rows)] = array[rows]
        self.n = len(rows)
        marks = self.bodies.marks[: self.n]
        marks[:, body.NEXT_IN_ISLAND] = target[marks[:, body.NEXT_IN_ISLAND]]
        self.pairs = select_pairs(self.pairs, target, self.n)
        self.is_listed = False

    def wake_with(self, row: int) -> None:
        """Wake the ball in a row and all balls that fell asleep with it."""
        marks = self.bodies.marks
        while marks[row, body.FLAGS] & body.ASLEEP:
            marks[row, body.FLAGS] &= ~body.ASLEEP
            marks[row, body.STILL_STEPS] = 0
            marks[row, body.NEXT_IN_ISLAND], row = row, marks[row, body.NEXT_IN_ISLAND]
            self.is_listed = False

    def wake_all(self) -> None:
        marks = self.bodies.marks[: self.n]
        if (marks[:, body.FLAGS] & body.ASLEEP).any():
            self.is_listed = False
        marks[:, body.FLAGS] &= ~body.ASLEEP
        marks[:, body.STILL_STEPS] = 0
        marks[:, body.NEXT_IN_ISLAND] = np.arange(self.n)

    def edit(self, rows: npt.NDArray[np.intp], values: Mapping[str, float]) -> None:
        """Set checked values of these rows; a new radius keeps density, angle and spin."""
        for row in rows.tolist():
            self.wake_with(row)
        pos, vel, surface, _, _ = self.bodies
        if "radius" in values:
            ratio = values["radius"] / pos[rows, body.RADIUS]
            pos[rows, body.RIM_ARC] *= ratio
            vel[rows, body.RIM_SPEED] *= ratio
            vel[rows, body.INVERSE_MASS] /= ratio * ratio
            pos[rows, body.RADIUS] = values["radius"]
        radius = pos[rows, body.RADIUS]
        if "density" in values:
            vel[rows, body.INVERSE_MASS] = 1.0 / (values["density"] * (np.pi * radius * radius))
        for name, array, column in (
            ("x", pos, body.X), ("y", pos, body.Y), ("vx", vel, body.VX), ("vy", vel, body.VY),
            ("restitution", surface, body.RESTITUTION), ("friction", surface, body.FRICTION),
        ):  # fmt: skip
            if name in values:
                array[rows, column] = values[name]
        if "theta" in values:
            pos[rows, body.RIM_ARC] = values["theta"] * radius
        if "omega" in values:
            vel[rows, body.RIM_SPEED] = values["omega"] * radius
        self.is_listed = False

    def records(self, pos: Floats) -> npt.NDArray[np.void]:
        """All balls, but at the places `pos`, shape (n, 4), as a new array of ARENA_BODY."""
        vel, marks = self.bodies.vel[: self.n], self.bodies.marks[: self.n]
        rows = np.empty(self.n, ARENA_BODY)
        rows["id"] = marks[:, body.ID]
        rows["x"], rows["y"] = pos[:, body.X], pos[:, body.Y]
        rows["radius"] = pos[:, body.RADIUS]
        rows["theta"] = pos[:, body.RIM_ARC] / pos[:, body.RADIUS]
        rows["vx"], rows["vy"] = vel[:, body.VX], vel[:, body.VY]
        rows["omega"] = vel[:, body.RIM_SPEED] / pos[:, body.RADIUS]
        rows["asleep"] = marks[:, body.FLAGS] & body.ASLEEP != 0
        rows["bounced"] = marks[:, body.FLAGS] & body.BOUNCED != 0
        return rows

    def values(self, row: int) -> dict[str, float]:
        """All values of the ball in a row that RANGES lists, and its mass in kg."""
        pos, vel, surface, _, _ = self.bodies
        radius = float(pos[row, body.RADIUS])
        mass = 1.0 / float(vel[row, body.INVERSE_MASS])
        return {
            "x": float(pos[row, body.X]),
            "y": float(pos[row, body.Y]),
            "theta": float(pos[row, body.RIM_ARC]) / radius,
            "vx": float(vel[row, body.VX]),
            "vy": float(vel[row, body.VY]),
            "omega": float(vel[row, body.RIM_SPEED]) / radius,
            "radius": radius,
            "density": mass / (np.pi * radius * radius),
            "restitution": float(surface[row, body.RESTITUTION]),
            "friction": float(surface[row, body.FRICTION]),
            "mass": mass,
        }

    @property
    def mass(self) -> Floats:
        """Masses in kg, shape (n,)."""
        found: Floats = 1.0 / self.bodies.vel[: self.n, body.INVERSE_MASS]
        return found

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays, including unused room."""
        return sum(array.nbytes for array in (*self.bodies, *self.pairs))

    def copy(self) -> "BallTable":
        other = BallTable()
        other.n, other.is_listed = self.n, self.is_listed
        bodies, pairs = self.bodies._asdict(), self.pairs._asdict()
        other.bodies = Bodies(**{name: array.copy() for name, array in bodies.items()})
        other.pairs = NeighbourList(**{name: array.copy() for name, array in pairs.items()})
        return other

    def saved(self) -> dict[str, Any]:
        """The arrays as bytes, for `load`."""
        bodies = {
            name: np.ascontiguousarray(array[: self.n]).tobytes()
            for name, array in self.bodies._asdict().items()
        }
        pairs = {name: array.tobytes() for name, array in self.pairs._asdict().items()}
        return {"n": self.n, "bodies": bodies, "pairs": pairs, "is_listed": self.is_listed}

    def load(self, saved: Mapping[str, Any]) -> None:
        """Replace the contents by those of a saved table."""
        n = self.n = saved["n"]
        self.bodies = _room_for(max(n, _FIRST_ROOM))
        for name, array in self.bodies._asdict().items():
            array[:n] = _read(saved["bodies"][name], array)
        self.pairs = NeighbourList(
            **{name: _read(saved["pairs"][name], array).copy()
               for name, array in no_pairs(0)._asdict().items()}
        )  # fmt: skip
        self.is_listed = saved["is_listed"]


def _read(part: bytes, like: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The rows in these bytes, of the type and width of `like`."""
    return np.frombuffer(part, like.dtype).reshape(-1, *like.shape[1:])


def _room_for(n: int) -> Bodies:
    """Empty rows. The last row of `pos` and `vel` represents fixed shapes: zero inverse mass."""
    return Bodies(
        pos=np.zeros((n + 1, 4)),
        vel=np.zeros((n + 1, 4)),
        surface=np.zeros((n, 2)),
        anchor=np.zeros((n, 3)),
        marks=np.zeros((n, 4), np.int32),
    )
