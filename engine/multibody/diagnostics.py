"""Energy, momentum and contacts of an arena: computed when somebody asks, and only then."""

from dataclasses import dataclass

import numpy as np

from engine.multibody.bodies import BallTable, no_pairs
from engine.multibody.solver.contact_solver import deepest
from engine.multibody.solver.layout import (
    ASLEEP,
    FLAGS,
    RADIUS,
    ROLL,
    VX,
    VY,
    Bodies,
    Statics,
    X,
    Y,
)
from engine.multibody.solver.neighbour_list import renew


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Energies in J (potential: zero at y = 0), momentum in kg m/s, angular momentum about the
    origin in kg m^2/s; contacts that touch; penetration, the deepest overlap, in m and in radii
    of the smaller ball; numbers of sleeping and of all balls."""

    kinetic: float
    potential: float
    rotational: float
    px: float
    py: float
    angular: float
    contacts: int
    penetration: float
    penetration_radii: float
    asleep: int
    count: int

    @property
    def total(self) -> float:
        """Sum of the energies."""
        return self.kinetic + self.potential + self.rotational


def diagnose(table: BallTable, statics: Statics, gravity: float) -> Diagnostics:
    """Diagnostics of the balls of a table; changes nothing."""
    n = table.n
    pos, vel = table.bodies.pos[:n], table.bodies.vel[:n]
    mass = table.mass
    metres, radii, contacts = _contacts(table, statics)
    turning = pos[:, X] * vel[:, VY] - pos[:, Y] * vel[:, VX]
    spin = 0.5 * pos[:, RADIUS] * vel[:, ROLL]
    return Diagnostics(
        kinetic=0.5 * float((mass * (vel[:, VX] ** 2 + vel[:, VY] ** 2)).sum()),
        potential=-gravity * float((mass * pos[:, Y]).sum()),
        rotational=0.25 * float((mass * vel[:, ROLL] ** 2).sum()),
        px=float((mass * vel[:, VX]).sum()),
        py=float((mass * vel[:, VY]).sum()),
        angular=float((mass * (turning + spin)).sum()),
        contacts=contacts,
        penetration=metres,
        penetration_radii=radii,
        asleep=int(np.count_nonzero(table.bodies.marks[:n, FLAGS] & ASLEEP)),
        count=n,
    )


def _contacts(table: BallTable, statics: Statics) -> tuple[float, float, int]:
    """Deepest overlap in m and in radii, and the number of contacts, those of sleepers included.

    On copies with all awake, since a list of pairs leaves out sleepers, and making one gives out
    budgets anew.
    """
    if table.n == 0:
        return 0.0, 0.0, 0
    body = table.bodies
    marks = body.marks.copy()
    marks[:, FLAGS] &= ~ASLEEP
    copy = Bodies(body.pos, np.zeros_like(body.vel), body.surface, body.home.copy(), marks)
    pairs, _ = renew(copy, table.n, statics, no_pairs(table.n), 0.0, 0.0)
    metres, radii, contacts = deepest(copy, table.n, pairs, statics)
    return float(metres), float(radii), int(contacts)
