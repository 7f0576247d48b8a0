"""An arena's settings and inputs: gravity of any direction, materials of pairs, odd values."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from plinko.engine import PlinkoError, World
from plinko.engine.board.model import Board
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.bodies import RANGES
from plinko.engine.multibody.events import Touch
from plinko.engine.multibody.scenes import sandbox
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry
from plinko.engine.parameters import MOST_STEPS

SPACE = StaticGeometry()
BOX = StaticGeometry.box(4.0, 4.0, restitution=0.0)


def run(arena: Arena, steps: int) -> Arena:
    for _ in range(steps):
        arena.step()
    return arena


def places(arena: Arena) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in arena.bodies[["x", "y"]].tolist()]


@pytest.mark.parametrize(("down", "right"), [(-9.81, 0.0), (0.0, 9.81), (3.0, -4.0), (0.0, 0.0)])
def test_a_ball_flies_along_gravity_of_any_direction(down: float, right: float) -> None:
    dt, steps = 0.01, 50
    arena = Arena(SPACE, ArenaSettings(gravity=down, gravity_x=right, dt=dt, substeps=1))
    arena.add(0.0, 0.0, vx=1.0)
    start = arena.diagnostics().total
    run(arena, steps)
    ball = arena.ball(0)
    assert (ball["vx"], ball["vy"]) == pytest.approx((1.0 + 0.5 * right, 0.5 * down), abs=1e-9)
    fallen = 0.5 * dt * dt * steps * (steps + 1)  # of semi-implicit Euler
    assert ball["x"] == pytest.approx(0.5 + fallen * right, abs=1e-9)
    assert ball["y"] == pytest.approx(fallen * down, abs=1e-9)
    lag = dt * math.hypot(down, right) * math.hypot(ball["vx"], ball["vy"])
    assert arena.diagnostics().total == pytest.approx(start, abs=ball["mass"] * lag)


def test_gravity_to_the_right_is_the_mirror_image_of_gravity_down() -> None:
    wide, high = StaticGeometry.box(4.0, 2.0), StaticGeometry.box(2.0, 4.0)
    down = Arena(wide, ArenaSettings(gravity=9.81))
    right = Arena(high, ArenaSettings(gravity=0.0, gravity_x=9.81))
    for k in range(12):  # a ball at (x, y) in one box is at (y - 1, x + 2) in the other
        x, y = -0.9 + 0.15 * k, 1.2 + 0.02 * k
        down.add(x, y, vx=0.3, radius=0.07)
        right.add(y - 1.0, x + 2.0, vy=0.3, radius=0.07)
    run(down, 60)
    run(right, 60)
    mirrored = [(y - 1.0, x + 2.0) for x, y in places(down)]
    assert np.abs(np.array(mirrored) - np.array(places(right))).max() < 1e-9


def test_a_pile_falls_up_when_gravity_is_reversed_and_rests_there() -> None:
    arena = run(sandbox(60, seed=2, restitution=0.3), 900)
    assert not arena.awake
    arena.configure(gravity=-9.81)
    run(arena, 900)
    assert not arena.awake
    assert arena.bodies["y"].max() < 1.5
    assert arena.diagnostics().penetration_radii < 0.01


def bounces(arena: Arena, steps: int) -> list[float]:
    """The speeds of the ball's impacts, in their order."""
    run(arena, steps)
    return [event.speed for event in arena.take_events() if isinstance(event, Touch)]


@pytest.mark.parametrize("e", [0.05, 0.5, 0.9])
@pytest.mark.parametrize(("down", "right"), [(9.81, 0.0), (-9.81, 0.0), (0.0, 9.81)])
def test_restitution_can_be_read_from_the_speeds_of_impacts(
    e: float, down: float, right: float
) -> None:
    settings = ArenaSettings(gravity=down, gravity_x=right)
    arena = Arena(StaticGeometry.box(4.0, 4.0, restitution=e), settings)
    arena.add(0.0, 2.0, radius=0.1, restitution=e)
    first, second, *_ = bounces(arena, 300)
    # Between impacts, semi-implicit Euler errs by the square of the substeps of a flight.
    assert first == pytest.approx(math.sqrt(2.0 * 9.81 * 1.9), rel=1e-5)
    assert second / first == pytest.approx(e, rel=1e-3)


@pytest.mark.parametrize(("e", "mu"), [(0.05, 0.0), (0.6, 0.4)])
def test_one_knob_sets_the_material_of_every_pair(e: float, mu: float) -> None:
    arena = sandbox(1, seed=1, restitution=0.9, friction=0.2, sleeping=False)
    arena.set_material(restitution=e, friction=mu)
    first, second, *_ = bounces(arena, 300)
    assert second / first == pytest.approx(e, rel=1e-2)
    assert {arena.place.wall_material.friction, arena.ball(0)["friction"]} == {mu}


def test_clay_on_steel_rebounds_like_clay_and_steel_on_steel_like_steel() -> None:
    clay, steel = 0.05, 0.9
    arena = Arena(
        StaticGeometry.box(4.0, 4.0, restitution=steel), ArenaSettings(pair_restitution="lesser")
    )
    arena.add(-1.0, 3.0, radius=0.1, restitution=clay)
    arena.add(1.0, 3.0, radius=0.1, restitution=steel)
    run(arena, 240)
    speeds: dict[int, list[float]] = {0: [], 1: []}
    for event in arena.take_events():
        if isinstance(event, Touch):
            speeds[event.a].append(event.speed)
    for ball, e in ((0, clay), (1, steel)):
        assert speeds[ball][1] / speeds[ball][0] == pytest.approx(e, rel=2e-3)
    arena = Arena(SPACE, ArenaSettings(gravity=0.0, pair_restitution="lesser"))
    arena.add(0.0, 0.0, vx=1.0, restitution=clay)
    arena.add(0.5, 0.0, restitution=steel)
    run(arena, 60)
    one, other = (arena.ball(ball)["vx"] for ball in (0, 1))
    assert other - one == pytest.approx(clay, rel=1e-9)


@pytest.mark.parametrize("correction", [0.4, 0.6, 0.8])
def test_a_substep_removes_the_fraction_of_an_overlap_that_was_asked(correction: float) -> None:
    def left(**settings: Any) -> float:
        """The overlap of two balls after a step, m; at the start it is 0.1 m."""
        arena = Arena(SPACE, ArenaSettings(gravity=0.0, correction=correction, **settings))
        arena.add(0.0, 0.0, radius=1.0, restitution=0.0)
        arena.add(1.9, 0.0, radius=1.0, restitution=0.0)
        return run(arena, 1).diagnostics().penetration

    slop = 0.001
    rest = (0.1 - slop) * (1.0 - correction)
    assert left(substeps=1, projection=False) == pytest.approx(slop + rest, rel=1e-9)
    rest = (0.1 - slop) * (1.0 - correction) ** 4
    assert left(substeps=4, projection=False) == pytest.approx(slop + rest, rel=1e-9)
    assert left(substeps=1) < 0.008


def test_no_impact_depends_on_the_cells_of_the_broad_phase() -> None:
    def end(cell: float | None) -> Arena:
        arena = sandbox(80, seed=4, gravity=0.0, restitution=0.7, speed=3.0, cell=cell)
        return run(arena, 240)

    chosen = end(None)
    assert 0.05 < chosen.diagnostics().cell < 0.5
    for cell in (0.001, 0.02, 0.3, 100.0):
        arena = end(cell)
        assert arena.diagnostics().cell == cell
        assert (arena.bodies == chosen.bodies).all()


def test_balls_far_from_the_origin_find_each_other_however_small_they_are() -> None:
    arena = Arena(SPACE, ArenaSettings(gravity=0.0))
    arena.add(9e5, 9e5, radius=1e-4, vx=0.01, restitution=1.0, friction=0.0)
    arena.add(9e5 + 3e-4, 9e5, radius=1e-4, restitution=1.0, friction=0.0)
    run(arena, 60)
    assert [ball["vx"] for ball in map(arena.ball, (0, 1))] == pytest.approx([0.0, 0.01], abs=1e-9)


@pytest.mark.parametrize("long", [1e300, math.inf, (MOST_STEPS + 1) / 60, 10**400])
def test_a_time_of_too_many_steps_is_refused(long: float) -> None:
    arena = Arena(BOX)
    arena.add(0.0, 1.0)
    world = World(Board.preset("triangle-8"))
    world.add(seed=1)
    for each in (arena, world):
        with pytest.raises(PlinkoError, match="frame_time"):
            each.advance(long)
        assert each.tick == 0


ODD: tuple[object, ...] = (
    None, "x", "1", b"1", True, [], [1.0, 2.0], (), {}, {"x": 1.0}, math.nan, math.inf, -math.inf,
    10**400, -(10**400), 10**5000, 1e300, 1j, object(), np.array([1.0, 2.0]), np.array("x"),
)  # fmt: skip

BALL = {"x": 0.5, "y": 0.5}
CALLS: dict[str, Callable[[Arena, Any], object]] = {
    **{f"add {name}": partial(lambda name, arena, odd: arena.add(**{**BALL, name: odd}), name)
       for name in (*RANGES, "colour")},
    "add_many x": lambda arena, odd: arena.add_many(odd, [0.5, 0.6]),
    "add_many ids": lambda arena, odd: arena.add_many([0.5], [0.5], ids=odd),
    **{f"edit {name}": partial(lambda name, arena, odd: arena.edit(0, **{name: odd}), name)
       for name in RANGES},
    "edit ball": lambda arena, odd: arena.edit(odd, x=0.0),
    "edit_all": lambda arena, odd: arena.edit_all(restitution=odd),
    "edit_place": lambda arena, odd: arena.edit_place(friction=odd),
    "set_material": lambda arena, odd: arena.set_material(restitution=odd),
    "kick": lambda arena, odd: arena.kick(0, odd, 0.0),
    "kick spin": lambda arena, odd: arena.kick(0, 0.0, 0.0, odd),
    "kick ball": lambda arena, odd: arena.kick(odd, 0.0, 0.0),
    "impulse": lambda arena, odd: arena.impulse(0, 0.0, odd),
    "remove": lambda arena, odd: arena.remove(odd),
    **{f"configure {name}": partial(lambda name, arena, odd: arena.configure(**{name: odd}), name)
       for name in ArenaSettings.__slots__},
    "ball": lambda arena, odd: arena.ball(odd),
    "interpolated": lambda arena, odd: arena.interpolated(odd),
    "advance": lambda arena, odd: arena.advance(odd),
    "restore": lambda arena, odd: arena.restore(odd),
}  # fmt: skip


@pytest.mark.parametrize("call", CALLS)
def test_what_cannot_be_used_is_refused_by_name_and_changes_nothing(call: str) -> None:
    arena = Arena(BOX)
    arena.add(0.0, 1.0)
    used = 0
    for odd in ODD:
        before = arena.digest
        try:
            CALLS[call](arena, odd)
        except PlinkoError:
            assert arena.digest == before, odd
        else:
            used += 1
    # Nothing of it is a number, except that arrays may be lists and None may stand for a default.
    assert used <= 4
    for ball in arena.bodies["id"]:
        assert all(map(math.isfinite, arena.ball(int(ball)).values()))


def test_a_material_that_walls_cannot_have_changes_no_ball() -> None:
    arena = Arena(BOX)
    arena.add(0.0, 1.0)
    before = arena.digest
    with pytest.raises(PlinkoError, match="friction"):
        arena.set_material(restitution=0.1, friction=1000.0)
    assert arena.digest == before


@pytest.mark.parametrize(
    ("first", "then"),
    [((9e6, 0.0, 0.0), (2e6, 0.0, 0.0)), ((0.0, -1e7, 0.0), (0.0, -1.0, 0.0)),
     ((0.0, 0.0, 1e9), (0.0, 0.0, 1.0))],
)  # fmt: skip
def test_kicks_do_not_take_a_ball_beyond_the_range_of_speeds(
    first: tuple[float, float, float], then: tuple[float, float, float]
) -> None:
    arena = Arena(BOX)
    arena.add(0.0, 1.0)
    arena.kick(0, *first)
    before = arena.digest
    with pytest.raises(PlinkoError, match=r"is not from -1e\+0"):
        arena.kick(0, *then)
    if not then[2]:
        mass = arena.ball(0)["mass"]
        with pytest.raises(PlinkoError, match=r"is not from -1e\+07"):
            arena.impulse(0, then[0] * mass, then[1] * mass)
    assert arena.digest == before
