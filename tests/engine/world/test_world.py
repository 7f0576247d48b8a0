"""In a world each ball takes its own drop's path, with any step, other balls and pauses."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.scenes.contact_scenes import scene
from plinko.engine import Board, ParameterError, RecordError, SeedError, World, drop
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.parameters import SolverName
from plinko.engine.world.events import Contact, Landing
from tests.long import tries

TRIANGLE = Board.preset("triangle-12")
SOLVERS = ["exact", "stepped"]


def run(world: World, steps: int = 5000) -> list[Any]:
    """Step until nothing moves; returns all events."""
    events: list[Any] = []
    for _ in range(steps):
        if not world.awake:
            return events
        world.step()
        events += world.take_events()
    raise AssertionError("a ball is still moving")


def landings(events: list[Any]) -> dict[int, Landing]:
    return {event.ball: event for event in events if isinstance(event, Landing)}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "classic", "galton"])
def test_a_ball_in_a_world_is_the_drop_of_its_seed(solver: SolverName, name: str) -> None:
    board = Board.preset(name)
    world = World(board, solver=solver)
    for seed in range(4):
        world.add(seed)
    ended = landings(run(world))
    for seed in range(4):
        one, end = drop(board, seed, solver=solver), ended[seed]
        assert end.digest == one.digest
        assert (end.seed, end.bin, end.score) == (seed, one.bin, one.score)
        assert (end.t, end.x_end) == (one.duration, one.x_end)
        assert end.tick == math.ceil(one.duration * 60.0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_world_runs_the_same_with_and_without_contacts(solver: SolverName) -> None:
    told, untold = (World(TRIANGLE, solver=solver) for _ in range(2))
    for seed in range(4):
        assert told.add(seed) == untold.add(seed)
    while told.awake:
        told.step()
        untold.step(contacts=False)
        landed = [event for event in told.take_events() if isinstance(event, Landing)]
        assert untold.take_events() == landed
        assert untold.digest == told.digest, "which bounced in the last step is part of it"
    assert not untold.awake


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_contacts_of_a_world_are_the_impacts_of_its_drops(solver: SolverName) -> None:
    world = World(TRIANGLE, solver=solver)
    world.add(5)
    told = [event for event in run(world) if isinstance(event, Contact)]
    impacts = drop(TRIANGLE, 5, solver=solver).impacts
    hits = impacts[impacts["kind"] <= KIND_WALL]
    assert [(c.t, c.x, c.y, c.kind, c.index) for c in told] == [
        (r["t"], r["x"], r["y"], r["kind"], r["index"]) for r in hits
    ]
    assert all(contact.speed >= 0.0 for contact in told)


def test_a_contact_tells_the_speed_of_the_approach() -> None:
    """At the first impact after a free fall, it is the component along the normal."""
    world = World(TRIANGLE)
    world.add(5)
    first = next(event for event in run(world) if isinstance(event, Contact))
    assert first.kind == KIND_PEG
    peg = TRIANGLE.pegs[first.index]
    before = drop(TRIANGLE, 5).states(first.t - 1e-9)[0]
    nx, ny = first.x - peg.x, first.y - peg.y
    speed = -(before["vx"] * nx + before["vy"] * ny) / math.hypot(nx, ny)
    assert first.speed == pytest.approx(speed, rel=1e-6)


def frames_of(rate: float) -> Callable[[World], None]:
    def play(world: World) -> None:
        for _ in range(int(20.0 * rate)):
            world.advance(1.0 / rate)

    return play


def at_random(world: World) -> None:
    rng = np.random.default_rng(8)
    for _ in range(3000):
        world.advance(float(rng.exponential(1.0 / 90.0)))


@pytest.mark.parametrize("name", ["triangle-16", "classic"])
def test_an_exact_world_gives_the_same_bits_whatever_its_step(name: str) -> None:
    """Worlds with steps of 1/30, 1/60, 1/144 and 0.0137 s, advanced by equal and random times."""
    board = Board.preset(name)
    results = []
    for dt in (1.0 / 60.0, 1.0 / 30.0, 1.0 / 144.0, 0.0137):
        for play in (frames_of(30.0), frames_of(144.0), at_random):
            world = World(board, dt=dt)
            for seed in range(3):
                world.add(seed)
            play(world)
            events = world.take_events()
            assert not world.awake
            results.append(
                [
                    [(e.t, e.x, e.y, e.kind, e.index, e.speed) for e in contacts_of(events, i)]
                    + [(e.t, e.x_end, e.bin, e.digest) for e in (landings(events)[i],)]
                    for i in range(3)
                ]
            )
    assert all(result == results[0] for result in results)


def contacts_of(events: list[Any], ball: int) -> list[Contact]:
    return [event for event in events if isinstance(event, Contact) and event.ball == ball]


def test_a_stepped_world_depends_on_its_own_step_alone() -> None:
    """The times by which it is advanced do not matter: the accumulator divides them into steps."""
    digests = set()
    for play in (frames_of(30.0), frames_of(60.0), frames_of(144.0), at_random):
        world = World(TRIANGLE, solver="stepped")
        world.add(11)
        play(world)
        digests.add(landings(world.take_events())[0].digest)
    assert digests == {drop(TRIANGLE, 11, solver="stepped").digest}


@pytest.mark.parametrize("solver", SOLVERS)
def test_adding_balls_changes_nothing_for_the_others(solver: SolverName) -> None:
    alone = World(TRIANGLE, solver=solver)
    alone.add(42)
    shared = World(TRIANGLE, solver=solver)
    shared.add(42)
    rng = np.random.default_rng(2)
    added = 0
    for _ in range(2000):
        if rng.random() < 0.2 and added < 60:
            shared.add(int(rng.integers(2**63)))
            added += 1
        alone.step()
        shared.step()
        if not alone.awake:
            break
        assert shared.bodies[0].tobytes() == alone.bodies[0].tobytes()
    assert added > 30
    one, other = landings(alone.take_events())[0], landings(shared.take_events())[0]
    assert one == other


@pytest.mark.parametrize(
    ("solver", "dt"),
    [("exact", 1 / 60), ("exact", 1 / 32), ("exact", 1 / 128), ("stepped", 1 / 60)],
)
def test_bodies_are_the_states_of_the_drops(solver: SolverName, dt: float) -> None:
    """To the bit, except that the stepped solver's velocities are those of the next substep."""
    world = World(TRIANGLE, solver=solver, dt=dt)
    world.add(9)
    one = drop(TRIANGLE, 9, solver=solver)
    for tick in range(1, int(1.6 / dt)):
        world.step()
        body, state = world.bodies[0], one.states(tick * world.dt)[0]
        if solver == "exact":
            names = ["x", "y", "theta", "vx", "vy", "omega"]
            assert body[names].tolist() == state[names].tolist()
        else:
            assert body["x"] == pytest.approx(state["x"], abs=1e-6)
            assert body["y"] == pytest.approx(state["y"], abs=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
@given(ticks=st.lists(st.integers(0, 120), min_size=1, max_size=4), first=st.integers(0, 2**32))
@pytest.mark.long
@settings(max_examples=tries(15, 200))
def test_a_restored_world_goes_on_to_the_bit(
    solver: SolverName, ticks: list[int], first: int
) -> None:
    """Save and restore at random ticks, with balls of different ages and half a step left over."""
    world = World(TRIANGLE, solver=solver)
    events: list[Any] = []
    twin = World(TRIANGLE, solver=solver)
    twin_events: list[Any] = []
    for i, wait in enumerate(ticks):
        for each in (world, twin):
            each.add(first + i)
            each.advance(wait / 60.0 + 0.005)
        events += world.take_events()
        twin_events += twin.take_events()
        saved = world.snapshot()
        world = World(TRIANGLE, solver=solver)
        world.restore(saved)
        assert world.snapshot() == saved
        assert world.digest == twin.digest
        assert world.bodies.tobytes() == twin.bodies.tobytes()
        assert world.interpolated(0.5).tobytes() == twin.interpolated(0.5).tobytes()
    assert events + run(world) == twin_events + run(twin)
    assert world.digest == twin.digest
    assert world.add(1) == twin.add(1)


def test_a_snapshot_of_another_world_is_refused_by_what_differs() -> None:
    saved = World(TRIANGLE).snapshot()
    others = {
        "board_digest": World(Board.preset("triangle-8")),
        "solver": World(TRIANGLE, solver="stepped"),
        "dt": World(TRIANGLE, dt=1.0 / 30.0),
    }
    for field, world in others.items():
        with pytest.raises(RecordError) as caught:
            world.restore(saved)
        assert caught.value.field == field
    for garbage in (b"", b"garbage", saved[:-7]):
        with pytest.raises(RecordError):
            World(TRIANGLE).restore(garbage)


@pytest.mark.parametrize("solver", SOLVERS)
@given(st.lists(st.floats(0.0, 0.3), min_size=1, max_size=20))
def test_alpha_is_the_part_of_a_step_left_over(solver: SolverName, times: list[float]) -> None:
    world = World(Board.preset("triangle-8"), solver=solver)
    world.add(0)
    total = 0.0
    for time in times:
        alpha = world.advance(time)
        total += time
        assert 0.0 <= alpha < 1.0
        assert (world.tick + alpha) / 60.0 == pytest.approx(total, abs=1e-12)
    assert world.time == world.tick * world.dt


def test_interpolation_lies_between_two_ticks() -> None:
    world = World(TRIANGLE)
    world.add(4)
    for _ in range(30):
        world.step()
    before = world.bodies
    world.step()
    after = world.bodies
    for name in ("x", "y", "theta"):
        assert world.interpolated(0.0)[name] == pytest.approx(before[name])
        assert world.interpolated(1.0)[name] == pytest.approx(after[name])
        half = world.interpolated(0.5)[name]
        assert half == pytest.approx(0.5 * (before[name] + after[name]))
    for bad in (-0.1, 1.1, math.nan, "half"):
        with pytest.raises(ParameterError):
            world.interpolated(bad)  # type: ignore[arg-type]


@pytest.mark.parametrize("solver", SOLVERS)
def test_events_come_in_order_of_time_then_kind_then_ball(solver: SolverName) -> None:
    world = World(TRIANGLE, solver=solver)
    starts = {}
    for i in range(40):
        starts[world.add(i)] = world.tick
        world.step()
    events = run(world)
    key = [
        (
            starts[event.ball] * world.dt + event.t,
            event.kind if isinstance(event, Contact) else KIND_WALL + 1,
            event.ball,
        )
        for event in events
    ]
    assert key == sorted(key)
    assert world.take_events() == []


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_world_sleeps_when_nothing_moves(solver: SolverName) -> None:
    world = World(TRIANGLE, solver=solver)
    assert not world.awake
    assert (world.count, world.tick, len(world.bodies)) == (0, 0, 0)
    world.step()
    assert world.tick == 1
    ball = world.add(0)
    assert world.awake
    assert world.bodies["id"].tolist() == [ball]
    run(world)
    assert (world.awake, world.count) == (False, 0)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_ball_that_cannot_land_leaves_the_world_with_a_reason(solver: SolverName) -> None:
    world = World(scene("apex").board, solver=solver)
    world.add(x=0.0)
    landing = landings(run(world))[0]
    assert (landing.bin, landing.score, landing.seed) == (None, 1.0, None)
    assert landing.unsettled == "balanced: at rest on a surface"
    assert landing.digest == drop(scene("apex").board, x=0.0, solver=solver).digest


@pytest.mark.parametrize("solver", SOLVERS)
def test_bounced_marks_the_steps_with_a_hit(solver: SolverName) -> None:
    world = World(TRIANGLE, solver=solver)
    world.add(6)
    while world.awake:
        world.step()
        hits = [event for event in world.take_events() if isinstance(event, Contact)]
        if world.awake:
            assert bool(world.bodies["bounced"][0]) is bool(hits)


def test_energy_and_momentum_are_those_of_the_balls() -> None:
    world = World(TRIANGLE)
    world.add(1)
    world.add(2)
    for _ in range(80):
        world.step()
    ball, bodies = TRIANGLE.ball, world.bodies
    kinetic = sum(0.5 * ball.mass * (b["vx"] ** 2 + b["vy"] ** 2) for b in bodies)
    spin = sum(0.25 * ball.mass * (ball.radius * b["omega"]) ** 2 for b in bodies)
    fallen = sum(ball.mass * TRIANGLE.gravity * b["y"] for b in bodies)
    energy = world.energy()
    assert energy.kinetic == pytest.approx(kinetic)
    assert energy.rotational == pytest.approx(spin)
    assert energy.potential == pytest.approx(-fallen)
    assert energy.total == pytest.approx(kinetic + spin - fallen)
    momentum = world.momentum()
    assert momentum.x == pytest.approx(ball.mass * float(bodies["vx"].sum()))
    assert momentum.y == pytest.approx(ball.mass * float(bodies["vy"].sum()))
    about = bodies["x"] * bodies["vy"] - bodies["y"] * bodies["vx"]
    assert momentum.angular == pytest.approx(
        float(ball.mass * about.sum() + ball.inertia * bodies["omega"].sum())
    )


@pytest.mark.parametrize("bad", [-0.1, math.nan, math.inf, -math.inf])
def test_an_invalid_frame_time_is_refused_with_its_value(bad: float) -> None:
    with pytest.raises(ParameterError) as caught:
        World(TRIANGLE).advance(bad)
    assert caught.value.field == "frame_time"
    assert repr(bad) in str(caught.value)


def test_a_bad_ball_is_refused_and_leaves_the_world_as_it_was() -> None:
    world = World(TRIANGLE)
    world.add(1)
    before = world.digest
    with pytest.raises(SeedError):
        world.add(-1)
    with pytest.raises(ParameterError):
        world.add(1, x=99.0)
    with pytest.raises(ParameterError):
        world.add()
    assert world.digest == before


@pytest.mark.parametrize("solver", SOLVERS)
def test_balls_keep_their_ids_when_others_land(solver: SolverName) -> None:
    world = World(Board.preset("triangle-8"), solver=solver)
    for i in range(30):
        world.add(i)
        world.step()
        world.step()
        assert world.bodies["id"].tolist() == sorted(world.bodies["id"])
    assert sorted(landings(run(world))) == list(range(30))
