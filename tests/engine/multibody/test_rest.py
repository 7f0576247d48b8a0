"""Piles come to rest, and whether they sleep meanwhile cannot be seen."""

import numpy as np
import numpy.typing as npt
import pytest

from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.scenes import sandbox
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry
from tests.long import tries

G = 9.81
FLOOR = StaticGeometry.box(200.0, 20.0, restitution=0.0, friction=0.5)


def places(arena: Arena) -> npt.NDArray[np.float64]:
    return np.column_stack([arena.bodies["x"], arena.bodies["y"]])


def moved(arena: Arena, since: npt.NDArray[np.float64]) -> float:
    """The farthest way of a ball since then, in its radii."""
    ways: npt.NDArray[np.float64] = np.hypot(*(places(arena) - since).T) / arena.bodies["radius"]
    return float(ways.max())


def run(arena: Arena, seconds: float) -> None:
    for _ in range(round(seconds / arena.settings.dt)):
        arena.step()


def sleep(arena: Arena) -> None:
    run(arena, 1.0)
    assert not arena.awake


def pile(n: int, **values: float) -> Arena:
    """A pile that has come to rest without sleeping."""
    usual = {"restitution": 0.3, "width": 6.0, "height": 6.0, "radii": (0.05, 0.11)}
    arena = sandbox(n, sleeping=False, **{**usual, **values})  # type: ignore[arg-type]
    run(arena, 40.0)
    return arena


def test_a_pile_that_sleeps_and_wakes_ten_times_stays() -> None:
    arena = pile(250, seed=1)
    arena.configure(sleeping=True)
    sleep(arena)
    before = places(arena)
    for _ in range(10):
        arena.wake_all()
        sleep(arena)
        assert moved(arena, before) < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("seed", tries([1], [1, 2, 3, 4]))
def test_a_pile_that_does_not_sleep_rests(seed: int) -> None:
    arena = sandbox(200, seed=seed, sleeping=False)
    run(arena, 20.0)
    before = places(arena)
    run(arena, 20.0)
    assert moved(arena, before) < 1e-6


def test_balls_removed_from_a_sleeping_pile_leave_the_impulses_of_the_others() -> None:
    """Two columns side by side: taking one away must not move the other."""
    arena = Arena(FLOOR, ArenaSettings())
    columns = [[arena.add(x, 20.0 - 0.1 * (2 * k + 1), radius=0.1) for k in range(8)]
               for x in (-1.0, 1.0)]  # fmt: skip
    run(arena, 2.0)
    assert not arena.awake
    other = arena.copy()
    for ball in columns[0]:
        arena.remove(ball)
    for each in (arena, other):
        each.wake_all()
        run(each, 1.0)
    assert np.abs(places(arena) - places(other)[8:]).max() < 1e-7


def rolling(c: float, speed: float, **settings: float) -> Arena:
    arena = Arena(FLOOR, ArenaSettings(rolling=c, sleeping=False, **settings))  # type: ignore[arg-type]
    arena.add(0.0, 19.9, radius=0.1, vx=speed, omega=speed / 0.1, restitution=0.0, friction=0.5)
    run(arena, 0.5)  # the first substep is flight
    return arena


@pytest.mark.parametrize("c", [0.0, 0.001, 0.02])
def test_rolling_slows_down_by_two_thirds_of_c_g_and_ends(c: float) -> None:
    arena = rolling(c, 2.0)
    before = arena.ball(0)["vx"]
    run(arena, 3.0)
    ball = arena.ball(0)
    assert before - ball["vx"] == pytest.approx(2.0 * c * G, rel=1e-9, abs=1e-12)
    assert ball["omega"] * 0.1 == pytest.approx(ball["vx"], rel=1e-3)
    if c == 0.02:
        run(arena, 20.0)
        assert abs(arena.ball(0)["vx"]) < 1e-12


@pytest.mark.parametrize("c", [0.0, 0.02])
def test_on_a_slope_a_ball_rests_up_to_c_and_rolls_beyond(c: float) -> None:
    steep, flat = (rolling(c, 0.0, gravity_x=slope * G) for slope in (0.03, 0.019))
    before = steep.ball(0)["vx"]
    for arena in (steep, flat):
        run(arena, 3.0)
    assert steep.ball(0)["vx"] - before == pytest.approx(2.0 * (0.03 - c) * G, rel=1e-9)
    assert (abs(flat.ball(0)["vx"]) < 1e-9) == (c > 0.0)


def test_without_friction_a_spinning_ball_keeps_its_spin() -> None:
    arena = Arena(FLOOR, ArenaSettings(rolling=0.1, sleeping=False))
    arena.add(0.0, 19.9, radius=0.1, omega=5.0, friction=0.0, restitution=0.0)
    run(arena, 2.0)
    assert arena.ball(0)["omega"] == pytest.approx(5.0, rel=1e-9)
