"""A world whose balls touch each other: the methods of any world, and what is different."""

import pytest

from benchmarks.scenes.contact_scenes import scene
from engine import Board, ParameterError, World
from engine.constants import KIND_BALL
from engine.world.events import Contact, Landing

BOARD = Board.preset("triangle-12")


def played(world: World, balls: int, every: int = 6, frames: int = 4000) -> list[Contact | Landing]:
    found: list[Contact | Landing] = []
    for k in range(frames):
        if k % every == 0 and k < balls * every:
            world.add(k)
        world.step()
        found += world.take_events()
        if k > balls * every and not world.awake:
            return found
    raise AssertionError("a ball is still moving")


def test_every_ball_ends_and_balls_hit_each_other() -> None:
    world = World(BOARD, solver="stepped", interacting=True)
    events = played(world, 40, every=20)
    ends = [e for e in events if isinstance(e, Landing)]
    assert sorted(e.ball for e in ends) == list(range(40))
    edges = BOARD.bins.edges
    for end in ends:
        if end.bin is not None:
            assert edges[end.bin] <= end.x_end <= edges[end.bin + 1]
            assert end.score == BOARD.bins.multipliers[end.bin]
    hits = [e for e in events if isinstance(e, Contact) and e.kind == KIND_BALL]
    assert len(hits) > 20
    assert all(0 <= e.index < 40 and e.index != e.ball and e.speed > 0.0 for e in hits)
    assert all(e.t >= 0.0 for e in events)


def test_the_same_inputs_give_the_same_digests() -> None:
    runs = []
    for _ in range(2):
        world = World(BOARD, solver="stepped", interacting=True)
        events = played(world, 15)
        runs.append(([e.digest for e in events if isinstance(e, Landing)], world.digest()))
    assert runs[0] == runs[1]


def test_a_restored_world_goes_on_bit_for_bit() -> None:
    world = World(BOARD, solver="stepped", interacting=True)
    copy = World(BOARD, solver="stepped", interacting=True)
    for k in range(60):
        if k % 5 == 0:
            world.add(k)
        world.step()
    world.take_events()
    copy.restore(world.snapshot())
    for _ in range(120):
        world.step()
        copy.step()
    assert copy.digest() == world.digest()
    assert copy.take_events() == world.take_events()
    assert (copy.bodies == world.bodies).all()


def test_a_ball_at_rest_on_the_board_ends_without_a_bin() -> None:
    world = World(scene("shelf").board, solver="stepped", interacting=True)
    world.add(x=0.0)
    for _ in range(600):
        world.step()
        if not world.awake:
            break
    (end,) = [e for e in world.take_events() if isinstance(e, Landing)]
    assert (end.bin, end.score) == (None, 1.0)
    assert end.unsettled == "balanced: at rest on a surface"
    assert world.count == 0


def test_energy_momentum_and_the_arena_agree() -> None:
    world = World(BOARD, solver="stepped", interacting=True)
    for seed in range(5):
        world.add(seed)
        for _ in range(10):
            world.step()
    arena = world.arena
    assert arena is not None
    now = arena.diagnostics()
    assert world.energy().total == pytest.approx(now.total)
    assert world.momentum().y == pytest.approx(now.py)
    assert world.momentum().angular == pytest.approx(now.angular)
    arena.kick(0, 3.0, 0.0)
    assert World(BOARD, solver="stepped").arena is None


def test_balls_that_touch_need_the_stepped_solver() -> None:
    with pytest.raises(ParameterError) as caught:
        World(BOARD, interacting=True)
    assert caught.value.field == "interacting"


def test_worlds_whose_balls_do_not_touch_do_not_take_each_others_snapshots() -> None:
    touching = World(BOARD, solver="stepped", interacting=True)
    with pytest.raises(ValueError, match="another solver"):
        World(BOARD, solver="stepped").restore(touching.snapshot())
