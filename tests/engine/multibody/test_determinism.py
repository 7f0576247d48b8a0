"""An arena has the same bits on every run, after a restore, without the JIT, and in any order."""

import numpy as np
import pytest

from plinko.engine.board.model import Board
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.scenes import galton, sandbox
from plinko.engine.multibody.settings import ArenaSettings
from plinko.engine.multibody.static_geometry import StaticGeometry
from tests.kit.python import run_python

SCENE = """
from plinko.engine.multibody.scenes import sandbox
from plinko.engine.multibody.arena import Arena
arena = sandbox(12, width=1.6, height=1.2, restitution=0.6, seed=3, radii=(0.05, 0.1), speed=3.0)
for tick in range(40):
    if tick == 10:
        arena.kick(3, 4.0, -6.0, 2.0)
    if tick == 20:
        arena.remove(5)
        arena.add(0.0, 0.3, vx=300.0, radius=0.04)
    arena.step()
print(arena.digest)
"""


def test_plain_python_gives_the_bits_of_compiled_code() -> None:
    """Without the JIT: impacts, contacts, a rebuilt neighbour list, a removed and a fast ball."""
    check = (
        "from plinko.engine.multibody.solver.step import step_balls\n"
        "assert not hasattr(step_balls, 'function')\n"
    )
    assert run_python(check + SCENE, NUMBA_DISABLE_JIT="1") == run_python(SCENE)


@pytest.mark.parametrize("tick", [1, 37, 90, 200])
def test_a_restored_arena_goes_on_bit_for_bit(tick: int) -> None:
    """Restored while balls fall, in a heap, and asleep."""
    arena = sandbox(60, width=2.0, height=3.0, restitution=0.4, seed=11, radii=(0.05, 0.1))
    for _ in range(tick):
        arena.step()
    saved = arena.snapshot()
    copy = Arena.from_snapshot(saved)
    assert copy.digest == arena.digest
    assert copy.snapshot() == saved
    for k in range(150):
        for one in (arena, copy):
            if k == 20:
                one.add(0.0, 0.1, vy=5.0)
            one.step()
    assert copy.digest == arena.digest
    assert copy.take_events() == [e for e in arena.take_events() if e.tick > tick]


def test_taking_snapshots_and_looking_change_nothing() -> None:
    seen, unseen = (galton(40, seed=2) for _ in range(2))
    for k in range(120):
        seen.step()
        unseen.step()
        if k % 7 == 0:
            seen.snapshot()
            seen.diagnostics()
            seen.take_events()
            assert len(seen.bodies) == 40
            seen.interpolated(0.3)
    assert seen.digest == unseen.digest


def test_the_order_in_which_balls_are_added_does_not_matter() -> None:
    """Only ids matter: grid, pairs and contacts are in the order of the ids."""
    rng = np.random.default_rng(6)
    n = 80
    x, y = 0.25 * (np.arange(n) % 10) - 1.2, 0.25 * (np.arange(n) // 10) + 0.2
    vx, radius = rng.normal(0, 2, n), rng.uniform(0.05, 0.12, n)
    digests = set()
    for order in (np.arange(n), np.arange(n)[::-1], rng.permutation(n)):
        arena = Arena(StaticGeometry.box(3.0, 3.0), ArenaSettings())
        for part in np.array_split(order, 3):
            arena.add_many(x[part], y[part], vx=vx[part], radius=radius[part], ids=part.tolist())
        assert arena.bodies["id"].tolist() == list(range(n))
        for _ in range(120):
            arena.step()
        digests.add(arena.digest)
    assert len(digests) == 1


def test_the_frame_rate_does_not_matter() -> None:
    digests = set()
    for rate in (30.0, 144.0, 17.3):
        arena = sandbox(30, seed=4)
        while arena.tick < 100:
            arena.advance(min(1.0 / rate, (100.25 - arena.tick) / 60.0))
        saved = Arena.from_snapshot(arena.snapshot())
        saved._accumulator = 0.0
        digests.add(saved.digest)
    assert len(digests) == 1


def test_the_geometry_of_a_board_survives_its_json_form() -> None:
    geometry = StaticGeometry.of_board(Board.preset("triangle-12"))
    again = StaticGeometry.from_dict(geometry.to_dict())
    assert again == geometry
    assert again.digest == geometry.digest
    assert geometry.digest != StaticGeometry.of_board(Board.preset("triangle-11")).digest
