"""Chipmunk 2D through pymunk, as its expert would set it up.

Chipmunk multiplies the elasticities and frictions of a pair: the ball has 1, the board has the
pair's value. The tolerated overlap, by default 0.1 units, is set to 0.1 mm. Chipmunk's damping
would slow the spin too, so drag is applied to the velocities before each step, to all balls at once
through pymunk's batch functions (this is part of the measured time). Sleeping is off.
"""

from typing import Any

import numpy as np

from benchmarks.contestants.common import AbsentError, Floats, decay_of, pairs
from benchmarks.contestants.python_engine import PythonEngine, Scene
from plinko.engine import Board

SLOP = 1e-4  # m


class Chipmunk(PythonEngine):
    name = "Chipmunk"

    def __init__(self) -> None:
        try:
            import pymunk
            import pymunk.batch
        except ImportError as error:
            raise AbsentError(f"Chipmunk: {error}; pip install --group bench") from error
        self._pymunk = pymunk

    def scene(self, board: Board, xs: Floats, dt: float) -> Scene:
        """A space with all balls in it."""
        return _Space(self._pymunk, board, xs, dt)


class _Space:
    def __init__(self, pymunk: Any, board: Board, xs: Floats, dt: float) -> None:
        self.dt, self.decay = dt, decay_of(board, dt)
        self.space = pymunk.Space()
        self.space.gravity = (0.0, board.gravity)
        self.space.collision_slop = SLOP
        ground = self.space.static_body
        peg, wall = pairs(board)
        for p in board.pegs:
            circle = pymunk.Circle(ground, p.radius, (p.x, p.y))
            circle.elasticity, circle.friction = peg.restitution, peg.friction
            self.space.add(circle)
        for w in board.walls:
            line = pymunk.Segment(ground, (w.x1, w.y1), (w.x2, w.y2), 0.0)
            line.elasticity, line.friction = wall.restitution, wall.friction
            self.space.add(line)
        for x in xs.tolist():
            body = pymunk.Body(board.ball.mass, board.ball.inertia)
            body.position = (x, board.drop.y)
            disc = pymunk.Circle(body, board.ball.radius)
            disc.elasticity = disc.friction = 1.0
            disc.filter = pymunk.ShapeFilter(group=1)  # balls pass through each other
            self.space.add(body, disc)
        self.count = len(xs)
        self.batch = pymunk.batch
        self.speeds = np.zeros(2 * self.count + 2)  # the last two belong to the static body
        self.before, self.after = pymunk.batch.Buffer(), pymunk.batch.Buffer()
        self.after.set_float_buf(self.speeds)

    def step(self) -> None:
        if self.decay != 1.0:
            fields = self.batch.BodyFields.VELOCITY
            self.before.clear()
            self.batch.get_space_bodies(self.space, fields, self.before)
            np.multiply(np.frombuffer(self.before.float_buf()), self.decay, out=self.speeds)
            self.batch.set_space_bodies(self.space, fields, self.after)
        self.space.step(self.dt)

    def read(self, positions: Floats, velocities: Floats) -> None:
        fields = self.batch.BodyFields.POSITION | self.batch.BodyFields.VELOCITY
        buffer = self.batch.Buffer()
        self.batch.get_space_bodies(self.space, fields, buffer)
        states = np.frombuffer(buffer.float_buf()).reshape(-1, 4)[: self.count]
        positions[:], velocities[:] = states[:, :2], states[:, 2:]
