"""Box2D 2.3 through its Python binding, as its expert would set it up.

Box2D is built for bodies of 0.1 to 10 m, and no impact slower than 1 m/s rebounds. The scene is
therefore ten times larger, which makes the threshold 0.1 m/s and the tolerated overlap 0.5 mm in
real size. Box2D gives a pair the larger restitution and the root of the product of the frictions.
The ball therefore has 0 and 1, and the board has the pair's restitution and the square of its
friction. linearDamping is set so that its rule v / (1 + c dt) equals exp(-k dt). Continuous
collision is left on, sleeping is off.
"""

from typing import Any

from benchmarks.contestants.common import AbsentError, Floats, decay_of, pairs
from benchmarks.contestants.python_engine import PythonEngine, Scene
from plinko.engine import Board

SCALE = 10.0  # Box2D metres per metre
VELOCITY_ITERATIONS = 8  # the manual's advice
POSITION_ITERATIONS = 3


class Box2d(PythonEngine):
    name = "Box2D"

    def __init__(self) -> None:
        try:
            import Box2D
        except ImportError as error:
            raise AbsentError(f"Box2D: {error}; pip install --group bench") from error
        self._box2d = Box2D

    def scene(self, board: Board, xs: Floats, dt: float) -> Scene:
        """A world with all balls in it."""
        return _World(self._box2d, board, xs, dt)


class _World:
    def __init__(self, b2: Any, board: Board, xs: Floats, dt: float) -> None:
        self.dt = dt
        self.world = b2.b2World(gravity=(0.0, SCALE * board.gravity), doSleep=False)
        ground = self.world.CreateStaticBody()
        peg, wall = pairs(board)
        for p in board.pegs:
            ground.CreateFixture(
                shape=b2.b2CircleShape(pos=(SCALE * p.x, SCALE * p.y), radius=SCALE * p.radius),
                restitution=peg.restitution,
                friction=peg.friction**2,
            )
        for w in board.walls:
            ends = [(SCALE * w.x1, SCALE * w.y1), (SCALE * w.x2, SCALE * w.y2)]
            ground.CreateFixture(
                shape=b2.b2EdgeShape(vertices=ends),
                restitution=wall.restitution,
                friction=wall.friction**2,
            )
        disc = b2.b2FixtureDef(
            shape=b2.b2CircleShape(radius=SCALE * board.ball.radius),
            density=board.ball.density,
            restitution=0.0,
            friction=1.0,
            filter=b2.b2Filter(groupIndex=-1),  # balls pass through each other
        )
        damping = (1.0 / decay_of(board, dt) - 1.0) / dt
        self.bodies = [
            self.world.CreateDynamicBody(
                position=(SCALE * x, SCALE * board.drop.y),
                fixtures=disc,
                linearDamping=damping,
                allowSleep=False,
            )
            for x in xs.tolist()
        ]

    def step(self) -> None:
        self.world.Step(self.dt, VELOCITY_ITERATIONS, POSITION_ITERATIONS)

    def read(self, positions: Floats, velocities: Floats) -> None:
        for row, body in enumerate(self.bodies):
            positions[row] = body.position
            velocities[row] = body.linearVelocity
        positions /= SCALE
        velocities /= SCALE
