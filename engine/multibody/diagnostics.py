"""Energy, momentum and contacts of an arena, computed on request only."""

from dataclasses import dataclass

import numpy as np

from plinko.engine.multibody.bodies import BallTable, no_pairs
from plinko.engine.multibody.solver.broad_phase import smallest_cell
from plinko.engine.multibody.solver.layout import body
from plinko.engine.multibody.solver.layout.body import Bodies
from plinko.engine.multibody.solver.layout.shape import StaticShapes
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.multibody.solver.neighbour_list import rebuild
from plinko.engine.multibody.solver.position_projection import deepest_overlap


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """Energies in J (potential: zero at the origin), momentum in kg m/s, angular momentum about the
    origin in kg m^2/s. contacts: number of touching pairs. penetration: deepest overlap in m, and
    in radii of the smaller ball. asleep, count: numbers of sleeping and of all balls. cell: size of
    the smallest cells of the broad phase in m, 0 without balls."""

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
    cell: float

    @property
    def total(self) -> float:
        """Sum of the energies."""
        return self.kinetic + self.potential + self.rotational


def diagnose(table: BallTable, statics: StaticShapes, settings: SolverSettings) -> Diagnostics:
    """Compute the diagnostics of a table's balls without changing them."""
    n = table.n
    pos, vel = table.bodies.pos[:n], table.bodies.vel[:n]
    mass = table.mass
    metres, radii, contacts = _contacts(table, statics, settings)
    fallen = settings.gravity_x * pos[:, body.X] + settings.gravity_y * pos[:, body.Y]
    turning = pos[:, body.X] * vel[:, body.VY] - pos[:, body.Y] * vel[:, body.VX]
    spin = 0.5 * pos[:, body.RADIUS] * vel[:, body.RIM_SPEED]
    return Diagnostics(
        kinetic=0.5 * float((mass * (vel[:, body.VX] ** 2 + vel[:, body.VY] ** 2)).sum()),
        potential=-float((mass * fallen).sum()),
        rotational=0.25 * float((mass * vel[:, body.RIM_SPEED] ** 2).sum()),
        px=float((mass * vel[:, body.VX]).sum()),
        py=float((mass * vel[:, body.VY]).sum()),
        angular=float((mass * (turning + spin)).sum()),
        contacts=contacts,
        penetration=metres,
        penetration_radii=radii,
        asleep=int(np.count_nonzero(table.bodies.marks[:n, body.FLAGS] & body.ASLEEP)),
        count=n,
        cell=float(smallest_cell(table.bodies, n, settings.cell)) if n else 0.0,
    )


def _contacts(
    table: BallTable, statics: StaticShapes, settings: SolverSettings
) -> tuple[float, float, int]:
    """Deepest overlap in m and in radii, and the number of contacts, including those of sleepers.

    Works on copies of the arrays. All balls are awake in them, because a neighbour list leaves out
    sleepers, and building the list changes the balls' margins.
    """
    if table.n == 0:
        return 0.0, 0.0, 0
    balls = table.bodies
    marks = balls.marks.copy()
    marks[:, body.FLAGS] &= ~body.ASLEEP
    copy = Bodies(balls.pos, np.zeros_like(balls.vel), balls.surface, balls.anchor.copy(), marks)
    pairs, _ = rebuild(copy, table.n, statics, no_pairs(table.n), settings)
    metres, radii, contacts = deepest_overlap(copy, table.n, pairs, statics)
    return float(metres), float(radii), int(contacts)
