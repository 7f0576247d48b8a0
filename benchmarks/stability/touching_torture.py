"""Counts faults in scenes of touching balls that are made to break the solver.

The only part of the solver's own geometry in use is the deepest overlap, which it computes from the
centres.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.stability.invariants import FAULTS, HANG
from plinko.engine import Arena, ArenaSettings, StaticGeometry
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import Wall
from plinko.engine.multibody.scenes import sandbox

JUPITER = 24.79

INSIDE = 0.5
"""Overlap in radii of the smaller ball that counts as tunnelling: a ball that is deeper may be
pushed out on the other side."""

GAIN = 5e-3
"""Tolerated energy gain, relative to the scene's energy. It covers the lift of balls that are
pushed out of an overlap, and the error of steps of a tenth of a second."""


@dataclass
class Scene:
    """An arena to watch for `frames` steps; overlap and energy count from step `settled` on."""

    name: str
    arena: Arena
    frames: int
    settled: int = 0


@dataclass
class Seen:
    """The faults of a scene, and the deepest overlap in radii after any step."""

    frames: int = 0
    deepest: float = 0.0
    faults: dict[str, int] = field(default_factory=lambda: dict.fromkeys(FAULTS, 0))


def catalogue(quick: bool) -> Iterator[Scene]:
    """All scenes, in the sizes of a quick or a full run."""
    frames = 20 if quick else 600
    many = 20 if quick else 100
    for e in (0.0, 1.0):
        for name, g in (("no gravity", 0.0), ("Earth", 9.81), ("Jupiter", JUPITER)):
            arena = sandbox(many, gravity=g, restitution=e, width=3.0, height=3.0, speed=3.0,
                            radii=(0.05, 0.1), friction=0.3, seed=1)  # fmt: skip
            yield Scene(f"restitution {e:g}, {name}", arena, frames)
    for dt in (1.0 / 1000.0, 1.0 / 240.0, 1.0 / 20.0, 1.0 / 10.0):
        for name, g in (("no gravity", 0.0), ("Jupiter", JUPITER)):
            arena = sandbox(min(many, 40), gravity=g, restitution=0.6, width=2.0, height=2.0,
                            seed=6, dt=dt, speed=2.0)  # fmt: skip
            yield Scene(f"frames of 1/{round(1.0 / dt)} s, {name}", arena, frames)
    for speed in (1e2, 1e3, 1e5):
        for e in (0.5, 1.0):
            arena = sandbox(25, restitution=e, width=3.0, height=3.0, speed=speed, seed=2)
            yield Scene(f"{speed:g} m/s, restitution {e:g}", arena, min(frames, 120))
    for where, densities in (("heavy on light", (1.0, 1e6)), ("light on heavy", (1e6, 1.0))):
        for e in (0.0, 0.8):
            name = f"mass ratio 1e6, {where}, restitution {e:g}"
            yield Scene(name, _stacked(densities, e), frames)
    yield Scene("radius ratio 1000", _grains(many), min(frames, 200))
    for n in (2, 3 * many):
        yield Scene(f"{n} balls in one place", _coincident(n), 480, settled=360)
    n = 200 if quick else 2000
    yield Scene(f"{n} balls dropped in a funnel", funnel(n), 30 if quick else 900)


def _stacked(densities: tuple[float, float], e: float) -> Arena:
    arena = Arena(StaticGeometry.box(1.0, 2.0, restitution=e), ArenaSettings())
    for k in range(5):
        x = -0.4 + 0.2 * k
        arena.add(x, 1.85, radius=0.09, density=densities[0], restitution=e)
        arena.add(x + 0.01, 1.6, radius=0.09, density=densities[1], restitution=e)
    return arena


def _grains(n: int) -> Arena:
    arena = Arena(StaticGeometry.box(2.0, 2.0, restitution=0.5), ArenaSettings())
    rng = np.random.default_rng(4)
    arena.add(0.0, 1.3, radius=0.5, density=50.0)
    arena.add_many(
        rng.uniform(-0.9, 0.9, n), rng.uniform(0.1, 0.6, n), vx=rng.normal(0, 1, n),
        radius=0.0005, density=50.0,
    )  # fmt: skip
    return arena


def _coincident(n: int) -> Arena:
    arena = Arena(StaticGeometry.box(3.0, 3.0), ArenaSettings())
    arena.add_many([0.0] * n, [1.5] * n, radius=0.05)
    return arena


def funnel(n: int) -> Arena:
    """A funnel 4 m wide over a closed bin, and n balls above it."""
    walls = (
        Wall(-2.0, 0.0, -0.25, 3.0), Wall(2.0, 0.0, 0.25, 3.0),
        Wall(-0.25, 3.0, -0.25, 3.2), Wall(0.25, 3.0, 0.25, 3.2),
        Wall(-2.0, 5.2, 2.0, 5.2), Wall(-2.0, 3.2, -2.0, 5.2), Wall(2.0, 3.2, 2.0, 5.2),
        Wall(-2.0, 3.2, -0.25, 3.2), Wall(2.0, 3.2, 0.25, 3.2),
        Wall(-2.0, 0.0, -2.0, -20.0), Wall(2.0, 0.0, 2.0, -20.0),
    )  # fmt: skip
    arena = Arena(StaticGeometry(walls=walls, wall_material=Material(0.4, 0.2)), ArenaSettings())
    k = np.arange(n)
    rng = np.random.default_rng(5)
    arena.add_many(
        -1.8 + 0.09 * (k % 40) + rng.uniform(-0.004, 0.004, n), -0.1 - 0.09 * (k // 40),
        radius=0.04, restitution=0.4, friction=0.2,
    )  # fmt: skip
    return arena


def watch(scene: Scene) -> Seen:
    """Play a scene and check it after every step."""
    arena = scene.arena
    left, right, top, bottom = arena.place.extent
    first = arena.diagnostics()
    mass = sum(arena.ball(int(i))["mass"] for i in arena.bodies["id"])
    weight = mass * arena.settings.gravity
    scale = first.kinetic + first.rotational + weight * (bottom - top)
    lag = arena.settings.gravity * arena.settings.dt / arena.settings.substeps
    seen = Seen(frames=scene.frames)
    for k in range(scene.frames):
        start = time.thread_time()
        arena.step()
        seen.faults["hang"] += int(time.thread_time() - start > HANG)
        b = arena.bodies
        values = np.array([b[name] for name in ("x", "y", "vx", "vy", "omega", "theta")])
        seen.faults["NaN"] += int((~np.isfinite(values)).any())
        outside = (b["x"] < left) | (b["x"] > right) | (b["y"] < top) | (b["y"] > bottom)
        seen.faults["escape"] += int(outside.any() or arena.count != first.count)
        now = arena.diagnostics()
        if k < scene.settled:
            first = now
            continue
        sway = lag * math.sqrt(2.0 * mass * max(now.kinetic, first.kinetic))
        grown = now.total - first.total > GAIN * scale + sway
        seen.faults["energy growth"] += int(grown)
        seen.deepest = max(seen.deepest, now.penetration_radii)
        seen.faults["tunnelling"] += int(now.penetration_radii > INSIDE)
    return seen


def to_dict(scene: Scene, seen: Seen) -> dict[str, Any]:
    """JSON form of a scene's counts."""
    return {
        "scene": scene.name,
        "frames": seen.frames,
        "balls": scene.arena.count,
        "deepest_radii": seen.deepest,
        "faults": seen.faults,
    }
