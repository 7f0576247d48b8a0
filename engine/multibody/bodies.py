"""The arrays behind an arena: balls in rows by ascending id, and the list of who may touch whom."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from engine.errors import ParameterError
from engine.multibody.solver.layout import (
    ARC,
    ASLEEP,
    FLAGS,
    FRICTION,
    ID,
    INVERSE_MASS,
    RADIUS,
    RESTITUTION,
    RING,
    ROLL,
    STILL,
    VX,
    VY,
    Bodies,
    Pairs,
    X,
    Y,
)

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]

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
"""What a ball's values may be; m, rad, m/s, rad/s, kg/m^2."""


def checked(name: str, value: object) -> Floats:
    """`value` as an array of floats in the range of `name`; ParameterError naming a bad one."""
    low, high = RANGES[name]
    try:
        found = np.atleast_1d(np.asarray(value, np.float64))
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name} {value!r:.60} is not a number", field=name) from error
    bad = ~((found >= low) & (found <= high))  # a NaN fails too
    if isinstance(value, bool) or found.ndim != 1 or bad.any():
        shown = float(found[bad][0]) if found.ndim == 1 and bad.any() else value
        raise ParameterError(f"{name} {shown!r} is not from {low:g} to {high:g}", field=name)
    return found


def no_pairs(n: int) -> Pairs:
    """A list of nothing for n balls."""
    zeros = np.zeros(n + 1, np.int32)
    none = np.zeros(0, np.int32)
    return Pairs(zeros, none, np.zeros((0, 2)), zeros.copy(), none.copy())


class BallTable:
    """Rows of balls with room to grow. `n` rows are in use; rows change when balls go."""

    def __init__(self) -> None:
        self.n = 0
        self.bodies = _room_for(_FIRST_ROOM)
        self.pairs = no_pairs(0)
        self.is_listed = False
        """Whether `pairs` is a list of the balls as they are; else it only keeps impulses."""

    @property
    def ids(self) -> Ints:
        """Ids of the rows in use, ascending; a view."""
        return self.bodies.marks[: self.n, ID]

    def row(self, ball: object) -> int:
        """Row of the ball with this id; ParameterError if there is none."""
        if isinstance(ball, int | np.integer) and not isinstance(ball, bool):
            row = int(np.searchsorted(self.ids, ball))
            if row < self.n and self.ids[row] == ball:
                return row
        raise ParameterError(f"there is no ball {ball!r:.40}", field="id")

    def append(self, ids: Ints, values: Mapping[str, Floats]) -> None:
        """Add balls with all values of RANGES, arrays of one length; ids new and ascending."""
        count, first = len(ids), self.n
        self._reserve(first + count)
        rows = slice(first, first + count)
        radius = values["radius"]
        pos, vel, surface, _, marks = self.bodies
        pos[rows, X], pos[rows, Y] = values["x"], values["y"]
        pos[rows, ARC], pos[rows, RADIUS] = values["theta"] * radius, radius
        vel[rows, VX], vel[rows, VY] = values["vx"], values["vy"]
        vel[rows, ROLL] = values["omega"] * radius
        vel[rows, INVERSE_MASS] = 1.0 / (values["density"] * (math.pi * radius * radius))
        surface[rows, RESTITUTION] = values["restitution"]
        surface[rows, FRICTION] = values["friction"]
        marks[rows] = 0
        marks[rows, ID] = ids
        marks[rows, RING] = np.arange(first, first + count)
        self.n += count
        old = self.pairs
        more = np.full(count, old.starts[-1], np.int32)
        self.pairs = old._replace(starts=np.concatenate([old.starts, more]))
        self.is_listed = False
        if first and ids[0] < self.ids[first - 1]:
            self.keep(np.argsort(self.ids, kind="stable"))

    def _reserve(self, count: int) -> None:
        room = len(self.bodies.marks)
        if count <= room:
            return
        if count > MAX_BALLS:
            raise ParameterError(f"{count} balls are more than {MAX_BALLS}", field="count")
        new = _room_for(max(count, room + room // 4))
        for name in Bodies._fields:
            mine, old = getattr(new, name), getattr(self.bodies, name)
            mine[: self.n] = old[: self.n]
        self.bodies = new

    def keep(self, rows: npt.NDArray[np.intp]) -> None:
        """Keep these rows, in this order, with the impulses between them; no sleeping ring may be
        cut (`wake_with` wakes one)."""
        target = np.full(self.n, -1, np.int32)
        target[rows] = np.arange(len(rows))
        for name in Bodies._fields:
            array = getattr(self.bodies, name)
            array[: len(rows)] = array[rows]
        self.n = len(rows)
        marks = self.bodies.marks[: self.n]
        marks[:, RING] = target[marks[:, RING]]
        old = self.pairs
        owner = np.repeat(np.arange(len(target), dtype=np.int32), np.diff(old.starts))
        other = np.where(old.other < 0, old.other, target[np.maximum(old.other, 0)])
        stays = (target[owner] >= 0) & ((old.other < 0) | (other >= 0))
        owner, other = target[owner[stays]], other[stays]
        order = np.argsort(owner, kind="stable")
        other = other[order].astype(np.int32)
        starts = np.zeros(self.n + 1, np.int32)
        np.cumsum(np.bincount(owner, minlength=self.n), out=starts[1:])
        self.pairs = no_pairs(self.n)._replace(
            starts=starts, other=other, impulse=old.impulse[stays][order].reshape(-1, 2)
        )
        self.is_listed = False

    def wake_with(self, row: int) -> None:
        """Wake the ball of a row and all that fell asleep with it."""
        marks = self.bodies.marks
        while marks[row, FLAGS] & ASLEEP:
            marks[row, FLAGS] &= ~ASLEEP
            marks[row, STILL] = 0
            marks[row, RING], row = row, marks[row, RING]
            self.is_listed = False

    def wake_all(self) -> None:
        """Wake all balls."""
        marks = self.bodies.marks[: self.n]
        if (marks[:, FLAGS] & ASLEEP).any():
            self.is_listed = False
        marks[:, FLAGS] &= ~ASLEEP
        marks[:, STILL] = 0
        marks[:, RING] = np.arange(self.n)

    @property
    def mass(self) -> Floats:
        """Masses in kg, shape (n,)."""
        found: Floats = 1.0 / self.bodies.vel[: self.n, INVERSE_MASS]
        return found

    @property
    def nbytes(self) -> int:
        """Memory of all arrays, with the room not in use."""
        return sum(array.nbytes for array in (*self.bodies, *self.pairs))

    def saved(self) -> dict[str, Any]:
        """What `load` needs."""
        bodies = {
            name: np.ascontiguousarray(getattr(self.bodies, name)[: self.n]).tobytes()
            for name in Bodies._fields
        }
        pairs = {name: array.tobytes() for name, array in self.pairs._asdict().items()}
        return {"n": self.n, "bodies": bodies, "pairs": pairs, "is_listed": self.is_listed}

    def load(self, saved: Mapping[str, Any]) -> None:
        """Become the table that was saved."""
        n = self.n = saved["n"]
        self.bodies = _room_for(max(n, _FIRST_ROOM))
        for name in Bodies._fields:
            array = getattr(self.bodies, name)
            array[:n] = np.frombuffer(saved["bodies"][name], array.dtype).reshape(n, -1)
        parts = saved["pairs"]
        self.pairs = Pairs(
            **{
                name: np.frombuffer(parts[name], np.int32).copy()
                for name in Pairs._fields
                if name != "impulse"
            },
            impulse=np.frombuffer(parts["impulse"], np.float64).reshape(-1, 2).copy(),
        )
        self.is_listed = saved["is_listed"]


def _room_for(n: int) -> Bodies:
    """Empty rows; the last of `pos` and `vel` is what stands still: no size, no inverse mass."""
    return Bodies(
        pos=np.zeros((n + 1, 4)),
        vel=np.zeros((n + 1, 4)),
        surface=np.zeros((n, 2)),
        home=np.zeros((n, 3)),
        marks=np.zeros((n, 4), np.int32),
    )
