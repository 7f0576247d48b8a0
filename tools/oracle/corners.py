"""Random corners: a ball that touches two surfaces, what the laws allow, and what the solver does.

`python -m tools.oracle.corners COUNT` prints how many of COUNT states have one solution of
the laws or several, which one the exact solver takes, and where time steps differ.
"""

import argparse
import math
import sys
from collections import Counter
from dataclasses import dataclass, replace
from random import Random
from typing import Final
from unittest import mock

import numpy as np
import numpy.typing as npt

from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Peg, Wall
from plinko.engine.constants import KIND_PEG, KIND_WALL, MAX_TIME
from plinko.engine.drops.trajectory import Trajectory, impacts_of
from plinko.engine.exact import event_log, initial_state
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.next_impact import BOUNCED, LIFTED
from plinko.engine.exact.outcome import IMPULSE_LIMIT, WEDGED
from plinko.engine.exact.trace import trace_many
from plinko.engine.exact.two_contacts import FLIES, LIFTS, meet
from plinko.engine.parameters import Exact
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series
from plinko.engine.physics.surface import side_of
from tests.engine.multibody.static_scenes import place
from tools.oracle.time_stepping import (
    OPEN,
    Body,
    Contact,
    Motion,
    Solution,
    Velocity,
    World,
    solutions,
    step,
    swept,
)

Floats = npt.NDArray[np.float64]

R: Final = 0.05
"""m; the ball's radius."""

EARLY: Final = 1e-4
"""s; so short that a ball from rest has nearly constant acceleration, and slips as at the start."""

ROOM: Final = 4096  # rows of a log


@dataclass(frozen=True)
class Corner:
    """A ball at (0, 0) that touches two surfaces.

    degrees: the angles of both normals from straight up, positive if they lean right. pegs: the
    radius in m of each surface if it is a peg, 0 for a wall. friction: of the ball with each.
    """

    degrees: tuple[float, float]
    pegs: tuple[float, float]
    friction: tuple[float, float]
    restitution: float = 0.0
    gravity: float = 9.81
    drag: float = 0.0

    @property
    def normals(self) -> list[tuple[float, float]]:
        angles = map(math.radians, self.degrees)
        return [(math.sin(angle), -math.cos(angle)) for angle in angles]

    def contacts(self, slip: int) -> list[Contact]:
        pairs = zip(self.normals, self.friction, strict=True)
        return [Contact(nx, ny, friction, 0.0, slip) for (nx, ny), friction in pairs]

    def solutions(self, omega: float) -> list[Solution]:
        """Accelerations of a ball at rest that spins at omega rad/s, by all forces that the laws
        allow. Its slip is -omega R at both contacts."""
        sign = (omega < 0.0) - (omega > 0.0)
        return solutions(self.contacts(sign), Velocity(0.0, self.gravity, 0.0), R)

    def coupling(self, omega: float) -> float:
        """p q: the force p with which a force of 1 at the second contact, with its friction, pushes
        off the first, times the force q of the reverse.

        The accelerations off both surfaces depend on the forces by the matrix ((1, p), (q, 1)),
        with the eigenvalues 1 +- sqrt(p q). For p q < 1 the laws have one solution.
        """
        (ax, ay), (bx, by) = self.normals
        a, b = (math.copysign(friction, omega) for friction in self.friction)
        p = ax * (bx - b * by) + ay * (by + b * bx)
        q = bx * (ax - a * ay) + by * (ay + a * ax)
        return p * q

    @property
    def board(self) -> Board:
        pegs, walls = [], []
        for (nx, ny), radius in zip(self.normals, self.pegs, strict=True):
            if radius > 0.0:
                pegs.append(Peg(-(R + radius) * nx, -(R + radius) * ny, radius))
            else:
                walls.append(Wall(-R * nx + ny, -R * ny - nx, -R * nx - ny, -R * ny + nx))
        board = place(
            pegs=tuple(pegs), walls=tuple(walls), restitution=self.restitution, friction=1.0,
            drag=self.drag, gravity=self.gravity, radius=R,
        )  # fmt: skip
        with mock.patch("plinko.engine.board.checks.playable.check"):
            for radius, friction in zip(self.pegs, self.friction, strict=True):
                material = Material(self.restitution, friction * friction)
                if radius > 0.0:
                    board = replace(board, peg_material=material)
                else:
                    board = replace(board, wall_material=material)
        return board

    @property
    def world(self) -> World:
        bodies = []
        for (nx, ny), radius, friction in zip(self.normals, self.pegs, self.friction, strict=True):
            ends = (-(R + radius) * nx, -(R + radius) * ny) * 2
            if radius == 0.0:
                ends = (-R * nx + ny, -R * ny - nx, -R * nx - ny, -R * ny + nx)
            bodies.append(Body(*ends, radius, self.restitution, friction))
        return World(bodies, self.gravity, self.drag, R)

    def path(self, velocity: Velocity) -> Trajectory:
        """The exact solver's path of a ball that meets the second surface while on the first."""
        board = self.board
        arrays, log = arrays_of(board), new_log(ROOM, ROOM)
        start = np.array([0.0, 0.0, 0.0, velocity.vx, velocity.vy, 0.0, velocity.omega])
        state = start.copy()
        # A peg has one item, a wall three; pegs come first.
        peg_count = len(board.pegs)
        walls = iter(range(peg_count, len(arrays.items), 3))
        pegs = iter(range(peg_count))
        a, b = (next(pegs if radius > 0.0 else walls) for radius in self.pegs)
        sides = [side_of(arrays.items, item, 0.0, 0.0) for item in (a, b)]
        how, item, side, resume = meet(arrays, state, a, sides[0], b, sides[1], log)
        outcome = np.array([how], np.int8)
        if how not in {WEDGED, IMPULSE_LIMIT}:
            phases = {FLIES: BOUNCED, LIFTS: LIFTED}
            initial = initial_state.in_flight(1)
            initial[0, initial_state.SURFACE] = item
            initial[0, initial_state.SIDE] = int(side)
            initial[0, initial_state.PHASE] = phases.get(how, initial_state.LYING)
            initial[0, initial_state.SLIP_ROOT] = resume.slip_root
            initial[0, initial_state.SECOND_SURFACE] = resume.second_surface
            trace_many(
                arrays, state.reshape(1, -1), initial, ROOM // 4, MAX_TIME, new_series(), log,
                outcome, np.zeros(1, np.int32), np.zeros(1, np.int32),
            )  # fmt: skip
        events, segments = log.counts[event_log.EVENTS], log.counts[event_log.SEGMENTS]
        return Trajectory(
            board, Exact(), start, state, int(outcome[0]), -1,
            impacts_of(log.events[:events], log.marks[:events]), log.segments[:segments],
        )  # fmt: skip

    def acceleration(self, omega: float) -> tuple[Floats, float]:
        """The exact solver's acceleration (x, y in m/s^2) of a ball that rests and spins at omega
        rad/s, and its spin, both right after the start."""
        states = self.path(Velocity(0.0, 0.0, omega)).states_at(np.array([0.0, EARLY]))
        return states[1, body.X : body.Y + 1] * (2.0 / EARLY**2), float(states[0, body.OMEGA])

    def stepped(self, velocity: Velocity, seconds: float, steps: int) -> Motion:
        """The motion by time steps."""
        world, now = self.world, Motion(0.0, 0.0, velocity)
        for _ in range(steps):
            now = step(world, now, seconds / steps)
        return now


def corner(choice: Random) -> Corner:
    """Any two surfaces that are not nearly parallel; only a peg and a wall differ in friction."""
    while True:
        a, b = choice.uniform(-170.0, 170.0), choice.uniform(-170.0, 170.0)
        if abs(math.sin(math.radians(a - b))) > 0.02:
            break
    pegs = choice.choice([(0.0, 0.0), (0.03, 0.08), (0.1, 0.0), (0.0, 0.2)])
    one, other = choice.uniform(0.0, 2.0), choice.uniform(0.0, 2.0)
    alike = (pegs[0] > 0.0) == (pegs[1] > 0.0)
    return Corner((a, b), pegs, (one, one if alike else other))


def spin(choice: Random) -> float:
    """rad/s; the ball slips at 5 cm/s or more."""
    return choice.choice([-1.0, 1.0]) * choice.uniform(1.0, 100.0)


def runs_into(choice: Random) -> tuple[Corner, Velocity]:
    """A plastic ball that rolls or slides at 1 m/s along the first surface into the second."""
    while True:
        made = corner(choice)
        (ax, ay), (bx, by) = made.normals
        towards = math.copysign(1.0, ay * bx - ax * by)
        if ay < -0.2:
            omega = choice.choice([towards / R, choice.uniform(-40.0, 40.0)])
            return made, Velocity(-towards * ay, towards * ax, omega)


def holds(solution: Solution) -> bool:
    return OPEN not in solution.modes


def motions(found: list[Solution]) -> list[Velocity]:
    """The different motions among solutions."""
    different: list[Velocity] = []
    for solution in found:
        if not any(is_alike(solution.velocity, other) for other in different):
            different.append(solution.velocity)
    return different


def is_alike(a: Velocity, b: Velocity) -> bool:
    """Within rounding of speeds or accelerations of 1 to 10."""
    return max(abs(a.vx - b.vx), abs(a.vy - b.vy), R * abs(a.omega - b.omega)) < 1e-5


def _at_rest(count: int) -> None:
    """Print what balls do that rest and spin in a corner."""
    choice = Random("at rest")
    kinds: Counter[str] = Counter()
    unswept = complex_ones = 0
    for _ in range(count):
        made, omega = corner(choice), spin(choice)
        found = made.solutions(omega)
        acceleration, _ = made.acceleration(omega)
        holds_on = bool(np.hypot(*acceleration) < 1e-3)
        is_same = steps_agree(made, Velocity(0.0, 0.0, omega))
        allowed = "one solution" if len(found) == 1 else "several" if found else "none"
        if len(found) > 1:
            allowed += f", the solver {'holds' if holds_on else 'falls'}"
        kinds[f"{allowed}; time steps {'agree' if is_same else 'differ'}"] += 1
        sign = (omega < 0.0) - (omega > 0.0)
        falls = Velocity(0.0, made.gravity, 1e6 * math.copysign(1.0, omega))
        if len(found) == 1 and swept(made.contacts(sign), falls, R) is None:
            unswept += 1
            complex_ones += made.coupling(omega) < 0.0
    for kind, number in kinds.most_common():
        sys.stdout.write(f"{number:6d}  {kind}\n")
    sys.stdout.write(
        f"{unswept:6d}  one that sweeps do not find, {complex_ones} with complex eigenvalues\n"
    )


def steps_agree(made: Corner, start: Velocity) -> bool:
    """Whether time steps lead to the exact solver's place after 20 ms, within 0.1 mm."""
    x, y = made.path(start).states_at(np.array([0.02]))[0, body.X : body.Y + 1].tolist()
    now = made.stepped(start, 0.02, 50)
    return math.hypot(now.x - x, now.y - y) < 1e-4


def hit(made: Corner, start: Velocity) -> tuple[Velocity | None, list[Velocity]]:
    """The velocity after the exact solver's impulses in turn, None if they do not end, and the
    velocities after impulses at once."""
    path = made.path(start)
    at_once = motions(solutions(made.contacts(0), start, R))
    if path.outcome == IMPULSE_LIMIT:
        return None, at_once
    hits = path.events[np.isin(path.marks[:, 0], (KIND_PEG, KIND_WALL))]
    last = hits[hits[:, 0] == 0.0][-1]
    return Velocity(*last[3:6].tolist()), at_once


def _running(count: int) -> None:
    """Print what plastic balls do that run into a corner."""
    choice = Random("running")
    kinds: Counter[str] = Counter()
    for _ in range(count):
        after, at_once = hit(*runs_into(choice))
        allowed = "one solution" if len(at_once) == 1 else "several" if at_once else "none"
        if after is None:
            kinds[f"{allowed}; impulses in turn do not end"] += 1
        else:
            is_one = any(is_alike(after, other) for other in at_once)
            kinds[f"{allowed}; impulses in turn are {'one' if is_one else 'another'}"] += 1
    for kind, number in kinds.most_common():
        sys.stdout.write(f"{number:6d}  {kind}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="number of states of each kind")
    count = parser.parse_args().count
    sys.stdout.write("a ball that rests and spins, with friction 0 to 2\n")
    _at_rest(count)
    sys.stdout.write("a plastic ball that rolls or slides from one surface into the other\n")
    _running(count)


if __name__ == "__main__":
    main()
