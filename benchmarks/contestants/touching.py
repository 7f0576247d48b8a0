"""Chipmunk and Box2D with balls that touch each other, as their experts would set them up.

Chipmunk multiplies the elasticities and the frictions of a pair. Box2D takes the larger restitution
and the root of the product of the frictions. The values are set so that each pair gets the scene's
restitution and friction. Chipmunk keeps its ten iterations and tolerates an overlap of 0.1 mm. In
Box2D no impact slower than 1 m/s rebounds, so its scene is ten times larger; it takes eight and
three iterations, as its manual advises, with the default continuous collision.
"""

from math import pi, sqrt
from typing import Any

import numpy as np

from benchmarks.contestants.common import AbsentError, Floats
from benchmarks.scenes.touching import DENSITY, DT, MATERIAL, Heap

SCALE = 10.0  # Box2D metres per metre
SLOP = 1e-4  # m
GRAVITY = 9.81
SLEEP_SECONDS = 0.5


class Chipmunk:
    name = "Chipmunk"

    def __init__(self, heap: Heap, *, sleeping: bool, steps: int = 1) -> None:
        try:
            import pymunk
        except ImportError as error:
            raise AbsentError(f"Chipmunk: {error}; pip install --group bench") from error
        self.steps = steps
        self.space: Any = pymunk.Space()
        self.space.gravity = (0.0, GRAVITY)
        self.space.collision_slop = SLOP
        if sleeping:
            self.space.sleep_time_threshold = SLEEP_SECONDS
        ground = self.space.static_body
        shapes: list[Any] = [
            pymunk.Circle(ground, p.radius, (p.x, p.y)) for p in heap.place.pegs
        ] + [pymunk.Segment(ground, (w.x1, w.y1), (w.x2, w.y2), 0.0) for w in heap.place.walls]
        self.bodies = []
        mass = DENSITY * pi * heap.radius**2
        for x, y in zip(heap.x.tolist(), heap.y.tolist(), strict=True):
            body = pymunk.Body(mass, 0.5 * mass * heap.radius**2)
            body.position = (x, y)
            self.space.add(body)
            self.bodies.append(body)
            shapes.append(pymunk.Circle(body, heap.radius))
        for shape in shapes:
            shape.elasticity = sqrt(MATERIAL.restitution)
            shape.friction = sqrt(MATERIAL.friction)
            self.space.add(shape)

    def step(self) -> None:
        """Advance by one frame."""
        for _ in range(self.steps):
            self.space.step(DT / self.steps)

    def places(self) -> Floats:
        """Centres in m, shape (n, 2)."""
        return np.array([tuple(body.position) for body in self.bodies])


class Box2d:
    name = "Box2D"

    def __init__(self, heap: Heap, *, sleeping: bool) -> None:
        try:
            import Box2D as b2  # noqa: N813 - the usual short name
        except ImportError as error:
            raise AbsentError(f"Box2D: {error}; pip install --group bench") from error
        self.world: Any = b2.b2World(gravity=(0.0, SCALE * GRAVITY), doSleep=sleeping)
        ground = self.world.CreateStaticBody()
        surface = {"restitution": MATERIAL.restitution, "friction": MATERIAL.friction}
        for p in heap.place.pegs:
            shape = b2.b2CircleShape(pos=(SCALE * p.x, SCALE * p.y), radius=SCALE * p.radius)
            ground.CreateFixture(shape=shape, **surface)
        for w in heap.place.walls:
            ends = [(SCALE * w.x1, SCALE * w.y1), (SCALE * w.x2, SCALE * w.y2)]
            ground.CreateFixture(shape=b2.b2EdgeShape(vertices=ends), **surface)
        disc = b2.b2FixtureDef(
            shape=b2.b2CircleShape(radius=SCALE * heap.radius), density=DENSITY, **surface
        )
        self.bodies = [
            self.world.CreateDynamicBody(
                position=(SCALE * x, SCALE * y), fixtures=disc, allowSleep=sleeping
            )
            for x, y in zip(heap.x.tolist(), heap.y.tolist(), strict=True)
        ]

    def step(self) -> None:
        """Advance by one frame."""
        self.world.Step(DT, 8, 3)

    def places(self) -> Floats:
        """Centres in m, shape (n, 2)."""
        return np.array([tuple(body.position) for body in self.bodies]) / SCALE


class Ours:
    name = "this engine"

    def __init__(self, heap: Heap, *, sleeping: bool) -> None:
        self.arena = heap.arena(sleeping=sleeping)

    def step(self) -> None:
        """Advance by one frame."""
        self.arena.step()

    def places(self) -> Floats:
        """Centres in m, shape (n, 2)."""
        bodies = self.arena.bodies
        return np.stack([bodies["x"], bodies["y"]], axis=1)


CONTESTANTS = (Ours, Chipmunk, Box2d)
