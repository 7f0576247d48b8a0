"""Touching balls under stress: no NaN, escape, growth of energy, or hang."""

import math

import numpy as np
import pytest

from benchmarks.stability.touching_torture import funnel
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.scenes import GRAVITY_PRESETS, sandbox
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry
from tests.long import tries

DEEPEST = 0.01
"""Allowed overlap after a frame, in radii; above 0.008 the solver pushes pairs apart."""


def watch(
    arena: Arena, frames: int, half: float, height: float, *, slack: float = 1e-3, every: int = 5
) -> float:
    """Step, and assert every few frames that states are finite, inside, and without energy gain.

    Energy may grow by the share `slack` of its start, plus the error from velocities that lag by
    half a substep. Returns the deepest overlap in radii.
    """
    first = arena.diagnostics()
    h = arena.settings.dt / arena.settings.substeps
    gravity = arena.settings.gravity
    depth_of_fall = gravity * height
    mass = sum(arena.ball(int(i))["mass"] for i in arena.bodies["id"])
    scale = first.kinetic + first.rotational + mass * depth_of_fall
    worst = 0.0
    for k in range(frames):
        arena.step()
        if k % every:
            continue
        b = arena.bodies
        for name in ("x", "y", "vx", "vy", "omega", "theta"):
            assert np.isfinite(b[name]).all(), name
        assert (np.abs(b["x"]) <= half).all()
        assert ((b["y"] >= 0.0) & (b["y"] <= height)).all()
        now = arena.diagnostics()
        lag = gravity * h * math.sqrt(2.0 * mass * max(now.kinetic, first.kinetic))
        assert now.total - first.total <= slack * scale + lag
        worst = max(worst, now.penetration_radii)
    assert arena.count == first.count
    return worst


@pytest.mark.parametrize("gravity", ["none", "Earth", "Jupiter"])
@pytest.mark.parametrize("e", [0.0, 1.0])
def test_dead_and_elastic_balls(e: float, gravity: str) -> None:
    arena = sandbox(
        80, gravity=GRAVITY_PRESETS[gravity], restitution=e, width=3.0, height=3.0, speed=3.0,
        seed=1, friction=0.3,
    )  # fmt: skip
    assert watch(arena, 300, 1.5, 3.0) < DEEPEST


@pytest.mark.parametrize("e", [0.0, 0.8])
@pytest.mark.parametrize("heavy_on_top", [True, False])
def test_a_mass_ratio_of_a_million(e: float, heavy_on_top: bool) -> None:
    arena = Arena(StaticGeometry.box(1.0, 2.0, restitution=e), ArenaSettings())
    densities = (1.0, 1e6) if heavy_on_top else (1e6, 1.0)
    for k in range(5):
        arena.add(-0.4 + 0.2 * k, 1.85, radius=0.09, density=densities[0], restitution=e)
        arena.add(-0.4 + 0.2 * k + 0.01, 1.6, radius=0.09, density=densities[1], restitution=e)
    assert watch(arena, 400, 0.5, 2.0, slack=2e-2) < DEEPEST
    if heavy_on_top:  # a light ball caught under heavy ones is no flywheel
        fallen = 5e6 * math.pi * 0.09**2 * 9.81 * 0.2
        for _ in range(200):
            arena.step()
            assert arena.diagnostics().rotational < 0.01 * fallen


def test_a_size_ratio_of_a_thousand() -> None:
    arena = Arena(StaticGeometry.box(2.0, 2.0, restitution=0.5), ArenaSettings())
    rng = np.random.default_rng(4)
    small = tries(100, 300)
    arena.add(0.0, 1.3, radius=0.5, density=50.0)
    arena.add_many(
        rng.uniform(-0.9, 0.9, small), rng.uniform(0.1, 0.6, small),
        vx=rng.normal(0, 1, small), radius=0.0005, density=50.0,
    )  # fmt: skip
    assert watch(arena, 200, 1.0, 2.0) < DEEPEST


def test_the_cost_of_a_size_ratio_of_a_thousand_is_not_quadratic() -> None:
    """The number of listed pairs, which decides the cost, grows like the number of balls."""
    arena = Arena(StaticGeometry.box(4.0, 4.0), ArenaSettings(gravity=0.0))
    rng = np.random.default_rng(3)
    n = 3000
    arena.add(0.0, 3.0, radius=0.5)
    arena.add_many(rng.uniform(-1.9, 1.9, n), rng.uniform(0.05, 2.4, n), radius=0.0005)
    arena.step()
    assert len(arena._table.pairs.other) < 3 * n


@pytest.mark.parametrize("speed", [1e2, 1e3, 1e5])
@pytest.mark.parametrize("e", [0.5, 1.0])
def test_speeds_up_to_a_hundred_kilometres_a_second(speed: float, e: float) -> None:
    arena = sandbox(25, restitution=e, width=3.0, height=3.0, speed=speed, seed=2, friction=0.2)
    assert watch(arena, 60, 1.5, 3.0, every=1) < DEEPEST


def test_balls_dropped_into_a_funnel() -> None:
    n = tries(200, 2000)
    arena = funnel(n)
    worst = 0.0
    for k in range(tries(240, 900)):
        arena.step()
        if k % 10 == 0:
            b = arena.bodies
            assert np.isfinite(b["x"]).all()
            assert (np.abs(b["x"]) < 2.0).all()
            assert (b["y"] < 5.2).all()
            worst = max(worst, arena.diagnostics().penetration_radii)
    assert arena.count == n
    assert worst < DEEPEST
    assert (arena.bodies["y"] > 3.2).any()


@pytest.mark.parametrize("n", [2, 60])
def test_balls_placed_exactly_on_each_other(n: int) -> None:
    arena = Arena(StaticGeometry.box(3.0, 3.0), ArenaSettings())
    arena.add_many([0.0] * n, [1.5] * n, radius=0.05)
    for _ in range(240):
        arena.step()
        b = arena.bodies
        assert np.isfinite(b["x"]).all()
        assert (np.abs(b["x"]) <= 1.5).all()
        assert ((b["y"] > 0.0) & (b["y"] < 3.0)).all()
    assert arena.diagnostics().penetration_radii < DEEPEST
    assert np.abs(b["vx"]).max() < 1.0


@pytest.mark.parametrize("dt", [1.0 / 1000.0, 1.0 / 240.0, 1.0 / 60.0, 1.0 / 20.0, 1.0 / 10.0])
@pytest.mark.parametrize("gravity", [0.0, 24.79])
def test_frames_from_a_thousandth_to_a_tenth_of_a_second(dt: float, gravity: float) -> None:
    arena = sandbox(
        40, gravity=gravity, restitution=0.6, width=2.0, height=2.0, seed=6, dt=dt, speed=2.0
    )
    worst = watch(arena, min(300, int(4.0 / dt)), 1.0, 2.0, slack=5e-3)
    assert worst < DEEPEST


def test_many_steps_of_a_small_scene() -> None:
    """Elastic balls that never rest; a million steps in the long mode."""
    arena = sandbox(
        4, restitution=1.0, friction=0.0, radii=(0.1, 0.2), width=1.5, height=1.5, speed=2.0
    )
    start = arena.diagnostics()
    for _ in range(tries(5_000, 1_000_000)):
        arena.step()
    end = arena.diagnostics()
    lag = 0.5 * 9.81 / 240.0
    change = (end.total + lag * end.py) - (start.total + lag * start.py)
    assert abs(change) < 1e-3 * end.kinetic
    assert arena.count == 4
