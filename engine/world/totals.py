"""The total energy and momentum of a world's balls."""

from dataclasses import dataclass

from plinko.engine.board.fields import BoardFields
from plinko.engine.board.parts import BallSpec
from plinko.engine.physics import body
from plinko.engine.physics.array_types import Floats


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


def energy_of(board: BoardFields, states: Floats) -> Energy:
    """The energy of balls on a board; states: shape (n, 7), as in `BallSet`."""
    ball = board.ball
    speed2 = float((states[:, body.VX] ** 2 + states[:, body.VY] ** 2).sum())
    return Energy(
        kinetic=0.5 * ball.mass * speed2,
        rotational=0.5 * ball.inertia * float((states[:, body.OMEGA] ** 2).sum()),
        potential=-ball.mass * board.gravity * float(states[:, body.Y].sum()),
    )


def momentum_of(ball: BallSpec, states: Floats) -> Momentum:
    """The momentum of equal balls; states: shape (n, 7), as in `BallSet`."""
    turning = states[:, body.X] * states[:, body.VY] - states[:, body.Y] * states[:, body.VX]
    return Momentum(
        x=ball.mass * float(states[:, body.VX].sum()),
        y=ball.mass * float(states[:, body.VY].sum()),
        angular=float(ball.mass * turning.sum() + ball.inertia * states[:, body.OMEGA].sum()),
    )
