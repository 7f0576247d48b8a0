"""A disc by time steps of Moreau's inclusion, and all solutions of the laws of contact.

A second reading of the laws, for discs that touch two surfaces; it shares no code with the engine.
Contacts push and rub with impulses P along the normals n and T along the tangents (-n_y, n_x), per
unit mass, so that for the speed v_n off each surface, the slip w and the coefficient mu

    0 <= P  orthogonal to  v_n + e v_n' >= 0        T in -mu P Sign(w)

where v_n' < 0 is the speed before. `step` finds them surface after surface, from zero (Gauss-Seidel
sweeps), for all surfaces that the disc touches after half a step without contacts (Moreau 1988;
Jean, Computer Methods in Applied Mechanics and Engineering 177, 1999, with theta = 1/2).
`solutions` finds all solutions, by trying whether each contact opens, sticks or slips.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

TOUCHING: Final = 1e-9
"""m; what is nearer is touched."""

SWEEPS: Final = 100
"""Sweeps of one step, at most."""

CLOSE: Final = 1e-13
"""Change of the impulses in the last sweep, relative to speeds and impulses."""

OPEN, STICKS, SLIPS, SLIPS_BACK = range(4)
"""What a contact does; `SLIPS` is along the tangent, `SLIPS_BACK` against it."""


class Contact(NamedTuple):
    """One contact. (nx, ny): unit normal towards the disc. rebound: speed e |v_n'| in m/s off the
    surface after an impact. slip: the direction (1 or -1) in which a disc slips whatever the
    impulses, as they are small; 0 if they decide."""

    nx: float
    ny: float
    friction: float
    rebound: float = 0.0
    slip: int = 0


class Velocity(NamedTuple):
    """m/s and, for omega, rad/s; or the change of a velocity, per step or per second."""

    vx: float
    vy: float
    omega: float


class Solution(NamedTuple):
    """What each contact does, the impulses (P and T of each contact), and the velocity after
    them."""

    modes: tuple[int, ...]
    impulses: Floats
    velocity: Velocity


def solutions(contacts: Sequence[Contact], free: Velocity, radius: float) -> list[Solution]:
    """All solutions of the laws, where `free` is the velocity without contacts.

    With accelerations instead of velocities, all forces that satisfy the laws of a disc at rest. At
    most one solution for each combination of modes: two contacts that stick may pinch the disc
    harder or less, with the same motion.
    """
    rows = np.array([row for c in contacts for row in ((c.nx, c.ny, 0.0), (-c.ny, c.nx, -1.0))])
    start = np.array([free.vx, free.vy, free.omega * radius])
    inverse_masses = np.diag([1.0, 1.0, 2.0])  # of a uniform disc, for vx, vy and omega R
    speeds = rows @ start
    speeds[::2] -= [c.rebound for c in contacts]
    answer = rows @ inverse_masses @ rows.T
    found = []
    for modes in product(*map(_modes, contacts)):
        for impulses in _candidates(contacts, modes, speeds, answer):
            if _fits(contacts, modes, impulses, speeds + answer @ impulses):
                vx, vy, spin = (start + inverse_masses @ rows.T @ impulses).tolist()
                found.append(Solution(modes, impulses, Velocity(vx, vy, spin / radius)))
                break
    return found


def _modes(contact: Contact) -> tuple[int, ...]:
    if contact.friction == 0.0 or contact.slip > 0:
        return OPEN, SLIPS
    return (OPEN, SLIPS_BACK) if contact.slip < 0 else (OPEN, STICKS, SLIPS, SLIPS_BACK)


def _candidates(
    contacts: Sequence[Contact], modes: tuple[int, ...], speeds: Floats, answer: Floats
) -> Iterator[Floats]:
    """Impulses with the equations of these modes. Where two contacts pinch the disc, they are not
    unique: then those follow at which an inequality begins or ceases to hold."""
    columns, stopped = [], []
    for i, (mode, contact) in enumerate(zip(modes, contacts, strict=True)):
        push, rub = np.eye(len(speeds))[2 * i : 2 * i + 2]
        if mode == STICKS:
            columns += [push, rub]
            stopped += [2 * i, 2 * i + 1]
        elif mode != OPEN:
            columns.append(push + contact.friction * (rub if mode == SLIPS_BACK else -rub))
            stopped.append(2 * i)
    if not columns:
        yield np.zeros(len(speeds))
        return
    span = np.array(columns).T
    matrix = (answer @ span)[stopped]
    least, _, rank, _ = np.linalg.lstsq(matrix, -speeds[stopped], rcond=1e-12)
    if not np.allclose(matrix @ least, -speeds[stopped], rtol=0.0, atol=1e-9 * _size(speeds)):
        return
    yield span @ least
    if rank < len(least):
        pinch = span @ np.linalg.svd(matrix)[2][-1]
        for i, contact in enumerate(contacts):
            for law in ((1.0, 0.0), (contact.friction, 1.0), (contact.friction, -1.0)):
                slope = float(np.dot(law, pinch[2 * i : 2 * i + 2]))
                if slope != 0.0:
                    at = -float(np.dot(law, (span @ least)[2 * i : 2 * i + 2])) / slope
                    yield span @ least + at * pinch


def _size(numbers: Floats) -> float:
    return float(np.abs(numbers).max(initial=0.0))


def _fits(
    contacts: Sequence[Contact], modes: tuple[int, ...], impulses: Floats, speeds: Floats
) -> bool:
    """Whether the inequalities of these modes hold, within rounding."""
    rounding = 1e-9 * max(_size(speeds), _size(impulses))
    for i, (mode, contact) in enumerate(zip(modes, contacts, strict=True)):
        push, rub = impulses[2 * i : 2 * i + 2]
        off, slip = speeds[2 * i : 2 * i + 2]
        decided = contact.friction == 0.0 or contact.slip != 0
        if mode == STICKS:
            slip = contact.friction * push - abs(rub)
        elif mode == OPEN or decided:
            slip = 0.0
        elif mode == SLIPS_BACK:
            slip = -slip
        if min(push, off, slip) < -rounding:
            return False
    return True


def swept(contacts: Sequence[Contact], free: Velocity, radius: float) -> Velocity | None:
    """The velocity after the impulses found by sweeps, or None if these do not converge."""
    vx, vy, omega = free
    impulses = [(0.0, 0.0)] * len(contacts)
    scale = abs(vx) + abs(vy)
    for _ in range(SWEEPS):
        change = 0.0
        for i, (nx, ny, friction, rebound, _) in enumerate(contacts):
            push, rub = impulses[i]
            more = max(rebound - vx * nx - vy * ny, -push)
            slip = vy * nx - vx * ny - omega * radius
            limit = friction * (push + more)
            rubs = min(max(rub - slip / 3.0, -limit), limit) - rub
            vx += more * nx - rubs * ny
            vy += more * ny + rubs * nx
            omega -= 2.0 * rubs / radius
            impulses[i] = push + more, rub + rubs
            change = max(change, abs(more), abs(rubs))
            scale = max(scale, push + more)
        if change <= CLOSE * scale:
            return Velocity(vx, vy, omega)
    return None


@dataclass(frozen=True)
class Body:
    """A peg of `radius` around (x1, y1), or with radius 0 a wall to (x2, y2)."""

    x1: float
    y1: float
    x2: float
    y2: float
    radius: float
    restitution: float
    friction: float

    def outward(self, x: float, y: float) -> tuple[float, float, float]:
        """Unit vector from the body to (x, y), and the distance in m."""
        ex, ey = self.x2 - self.x1, self.y2 - self.y1
        along = 0.0
        if self.radius == 0.0:
            along = ((x - self.x1) * ex + (y - self.y1) * ey) / (ex * ex + ey * ey)
            along = min(max(along, 0.0), 1.0)
        dx, dy = x - self.x1 - along * ex, y - self.y1 - along * ey
        distance = math.hypot(dx, dy)
        return dx / distance, dy / distance, distance - self.radius


class Motion(NamedTuple):
    x: float
    y: float
    velocity: Velocity


class World(NamedTuple):
    """What acts on a disc: bodies, gravity downwards in m/s^2, drag in 1/s, and its radius in m."""

    bodies: Sequence[Body]
    gravity: float
    drag: float
    radius: float


def step(world: World, now: Motion, h: float) -> Motion:
    """The motion h seconds later.

    Where sweeps do not converge, the solution with the least impulses counts.
    """
    x, y, (vx, vy, omega) = now
    half = 0.5 * h
    contacts = []
    for body in world.bodies:
        nx, ny, distance = body.outward(x + half * vx, y + half * vy)
        if distance <= world.radius + TOUCHING:
            rebound = body.restitution * max(-vx * nx - vy * ny, 0.0)
            contacts.append(Contact(nx, ny, body.friction, rebound))
    less, more = 1.0 - half * world.drag, 1.0 + half * world.drag
    after = Velocity(vx * less / more, (vy * less + h * world.gravity) / more, omega)
    if contacts:
        found = swept(contacts, after, world.radius)
        if found is None:
            every = solutions(contacts, after, world.radius)
            found = min(every, key=lambda s: _size(s.impulses)).velocity
        after = found
    return Motion(x + half * (vx + after.vx), y + half * (vy + after.vy), after)
