"""Many balls of a billiard at one instant: launch them, advance them, read their states."""

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow_many import HALVINGS, REACHED, REASONS, Balls, flow_many, new_space
from benchmarks.billiards.repeat import arrays_and_repeat
from plinko.engine.board.form import MAX_COORDINATE
from plinko.engine.errors import ParameterError
from plinko.engine.parameters import number
from plinko.engine.physics import body, tangent

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MAX_IMPACTS: Final = 1 << 40
"""Default limit of one ball's impacts: more than a machine computes in a day."""

MAX_SPEED: Final = 1e6
"""Largest speed of a ball at its start, m/s."""

MAX_TIME: Final = 1e12
"""s. At this size, successive float64 times are 0.12 ms apart."""


@dataclass(frozen=True, eq=False)
class Flow:
    """n balls of a billiard at the instant `time`, in s; `launch` makes it, `until` advances it."""

    billiard: Billiard
    time: float
    _balls: Balls = field(repr=False)

    def until(self, time: float, max_impacts: int = MAX_IMPACTS) -> "Flow":
        """A new flow with the balls at a later `time`, in s; this one does not change.

        A ball stops early after `max_impacts` impacts in all, if it stays on a surface, or if it
        escapes far from the board. `stopped` lists such balls.
        """
        number(time, "time", self.time, MAX_TIME)
        balls = self._balls.copy()
        board, repeat = arrays_and_repeat(self.billiard)
        flow_many(board, repeat, balls, float(time), max_impacts, new_space())
        return Flow(self.billiard, float(time), balls)

    @property
    def places(self) -> Floats:
        """Centres in m in the whole plane, not within one cell; shape (n, 2)."""
        inside = self._balls.states[:, [body.X, body.Y]]
        if self.billiard.cell is None:
            return inside
        far: Floats = self._balls.cells @ np.array(self.billiard.cell)
        return inside + far

    @property
    def velocities(self) -> Floats:
        """In m/s, shape (n, 2)."""
        return self._balls.states[:, [body.VX, body.VY]]

    @property
    def impacts(self) -> Ints:
        """Impacts of each ball since its start, shape (n,)."""
        return self._balls.impacts

    @property
    def stopped(self) -> dict[int, str]:
        """The balls that did not reach `time`: number and reason."""
        rows = np.flatnonzero(self._balls.outcomes != REACHED)
        return {int(i): REASONS[self._balls.outcomes[i]] for i in rows}

    @property
    def growth(self) -> Floats:
        """Natural logarithm of the length of each ball's tangent (in m and m/s), shape (n,).

        Raises ParameterError if the flow was launched without tangents.
        """
        if self._balls.tangents.shape[1] == 0:
            raise ParameterError(
                "this flow has no tangents: launch it with tangents=True", field="tangents"
            )
        lengths = np.linalg.norm(self._balls.tangents, axis=1)
        found: Floats = np.log(lengths) + self._balls.halvings * (HALVINGS * math.log(2.0))
        return found


def launch(
    billiard: Billiard,
    places: npt.ArrayLike,
    velocities: npt.ArrayLike,
    *,
    tangents: bool = False,
) -> Flow:
    """Start n balls, without spin, at `places` (m) with `velocities` (m/s), both of shape (n, 2).

    tangents: also follow how a small change of each start grows, one that moves x and the velocity
    along y. Raises ParameterError if a value is not finite or a ball overlaps a peg.
    """
    at, v = _pairs(places, "places", MAX_COORDINATE), _pairs(velocities, "velocities", MAX_SPEED)
    if len(at) != len(v):
        raise ParameterError(f"{len(at)} places for {len(v)} velocities", field="velocities")
    states = np.zeros((len(at), body.SIZE))
    states[:, [body.X, body.Y]] = at
    states[:, [body.VX, body.VY]] = v
    rows = np.zeros((len(at), tangent.TANGENT_SIZE if tangents else 0))
    if tangents:
        rows[:, [tangent.DX, tangent.DVY]] = math.sqrt(0.5)
    cells = np.zeros((len(at), 2), np.int64)
    if billiard.cell is not None:
        cells = np.floor(at @ np.linalg.inv(np.array(billiard.cell))).astype(np.int64)
        states[:, [body.X, body.Y]] -= cells @ np.array(billiard.cell)
    counts = np.zeros(len(at), np.int64)
    outcomes = np.full(len(at), REACHED, np.int8)
    flow = Flow(
        billiard, 0.0, Balls(states, cells, counts, outcomes, rows, np.zeros(len(at), np.int64))
    )
    _check_outside_pegs(flow)
    return flow


def _pairs(value: npt.ArrayLike, name: str, limit: float) -> Floats:
    """`value` as an array of shape (n, 2); raises ParameterError beyond -limit to limit."""
    found = np.array(value, np.float64)
    if found.ndim != 2 or found.shape[1] != 2:
        raise ParameterError(f"{name} have the shape {found.shape}; it must be (n, 2)", field=name)
    bad = found[~(np.abs(found) <= limit)]  # a NaN is bad too
    if len(bad):
        raise ParameterError(f"{name}: {bad[0]} is not from -{limit:g} to {limit:g}", field=name)
    return found


def _check_outside_pegs(flow: Flow) -> None:
    """Raise ParameterError if a ball starts deeper in a peg than rounding explains."""
    board, _ = arrays_and_repeat(flow.billiard)
    states = flow._balls.states
    for x, y, square in board.centres:
        if square == 0.0:
            continue  # a wall, which has two sides, or the empty first row
        inside = (states[:, body.X] - x) ** 2 + (states[:, body.Y] - y) ** 2 < square * (1 - 1e-12)
        if inside.any():
            ball = int(np.argmax(inside))
            raise ParameterError(
                f"places[{ball}] {flow.places[ball].tolist()} is inside of a peg", field="places"
            )
