"""Many balls of a billiard, on boards that are open and that repeat."""

import math

import numpy as np
import pytest

from benchmarks.billiards import Billiard, launch, path
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Peg, Wall
from plinko.engine.errors import ParameterError
from plinko.engine.physics import body
from tests.benchmarks.billiards.scenes import BALL, CELL, box, lattice, patch

PLACES = np.array([(1.15, 0.0), (1.15, 0.1), (0.0, 1.2), (-3.45, 0.4)])
ANGLES = np.array([0.3, 1.1, 2.5, 4.0])
VELOCITIES = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def test_a_flow_goes_where_the_single_path_goes() -> None:
    flow = launch(patch(), PLACES, VELOCITIES).until(5.0)
    for i, (place, velocity) in enumerate(zip(PLACES, VELOCITIES, strict=True)):
        alone = path(patch(), (place[0], place[1]), (velocity[0], velocity[1]), 5.0)
        assert flow.places[i] == pytest.approx(alone.end[[body.X, body.Y]], abs=1e-10)
        assert flow.velocities[i] == pytest.approx(alone.end[[body.VX, body.VY]], abs=1e-10)
        assert flow.impacts[i] == len(alone.events)


def test_a_board_that_repeats_is_one_without_end() -> None:
    """Errors grow like exp(1.76 t), which is a factor of a thousand in four seconds."""
    open_board = launch(patch(), PLACES, VELOCITIES).until(4.0)
    repeated = launch(lattice(), PLACES, VELOCITIES).until(4.0)
    assert repeated.places == pytest.approx(open_board.places, abs=1e-11)
    assert repeated.impacts.tolist() == open_board.impacts.tolist()
    cells = np.array([(4, -7), (0, 3), (100, 20), (-5, -5)]) @ np.array(CELL)
    elsewhere = launch(lattice(), PLACES + cells, VELOCITIES).until(4.0)
    assert elsewhere.places - cells == pytest.approx(repeated.places, abs=1e-9)


def test_looks_in_between_change_nothing() -> None:
    at_once = launch(lattice(1.0), PLACES, VELOCITIES).until(3.0)
    looked_at = launch(lattice(1.0), PLACES, VELOCITIES)
    for time in (0.1, 0.7, 0.7, 1.9, 3.0):
        before = looked_at.places.copy()
        later = looked_at.until(time)
        assert looked_at.places.tobytes() == before.tobytes(), "a flow stays as it is"
        looked_at = later
    assert looked_at.places == pytest.approx(at_once.places, abs=1e-10)
    assert looked_at.impacts.tolist() == at_once.impacts.tolist()


def test_time_runs_back_as_it_ran() -> None:
    there = launch(lattice(), PLACES, VELOCITIES).until(4.0)
    back = launch(lattice(), there.places, -there.velocities).until(4.0)
    assert back.places == pytest.approx(PLACES, abs=1e-9)
    assert back.velocities == pytest.approx(-VELOCITIES, abs=1e-9)
    assert back.impacts.tolist() == there.impacts.tolist()


def test_nothing_is_lost_where_all_is_elastic() -> None:
    free = launch(lattice(), PLACES, VELOCITIES).until(1000.0)
    assert np.linalg.norm(free.velocities, axis=1) == pytest.approx(1.0, abs=1e-12)
    assert free.impacts.min() > 1000
    falling = launch(lattice(2.0), PLACES, VELOCITIES).until(50.0)
    energy = 0.5 * (falling.velocities**2).sum(axis=1) - 2.0 * falling.places[:, 1]
    assert energy == pytest.approx(0.5 - 2.0 * PLACES[:, 1], abs=1e-10)
    assert falling.stopped == {}


def test_a_ball_in_a_free_corridor_never_hits_anything() -> None:
    """The discs have a contact distance of 1 m and a spacing of 4 m: corridors are 2 m wide."""
    square = Billiard(pegs=(Peg(0.0, 0.0, 0.5),), ball=BALL, cell=((4.0, 0.0), (0.0, 4.0)))
    flow = launch(square, [(0.0, 2.0), (2.0, 2.9)], [(3.0, 0.0), (0.0, -5.0)]).until(1e3)
    assert flow.places == pytest.approx(np.array([(3e3, 2.0), (2.0, 2.9 - 5e3)]), abs=1e-9)
    assert flow.impacts.tolist() == [0, 0]


def test_a_ball_at_rest_where_nothing_pulls_stays_at_rest() -> None:
    flow = launch(lattice(), [(1.15, 0.0)], [(0.0, 0.0)]).until(1e6)
    assert flow.places.tolist() == [[1.15, 0.0]]


@pytest.mark.parametrize("gravity", [0.0, 1.0])
def test_a_tangent_grows_as_neighbours_part(gravity: float) -> None:
    h = 1e-8 * math.sqrt(0.5)
    flow = launch(lattice(gravity), PLACES, VELOCITIES, tangents=True).until(2.0)
    beside = launch(
        lattice(gravity), PLACES + np.array([h, 0.0]), VELOCITIES + np.array([0.0, h])
    ).until(2.0)
    moved = np.hstack([beside.places - flow.places, beside.velocities - flow.velocities])
    assert np.linalg.norm(moved, axis=1) / 1e-8 == pytest.approx(np.exp(flow.growth), rel=1e-4)
    assert flow.growth.max() > 2.0


def test_a_tangent_that_overflows_is_kept_as_its_logarithm() -> None:
    flow = launch(lattice(), PLACES, VELOCITIES, tangents=True).until(1000.0)
    assert flow.growth / 1000.0 == pytest.approx(1.76, abs=0.15)
    assert flow.growth.min() > math.log(1e308)


def test_what_does_not_come_to_the_instant_is_named() -> None:
    floor = Billiard(
        walls=(Wall(-1.0, 1.0, 1.0, 1.0),), ball=BallSpec(radius=0.1, restitution=0.5),
        material=Material(0.5, 0.0), gravity=9.81,
    )  # fmt: skip
    flow = launch(floor, [(0.0, 0.0), (5.0, 0.0)], [(0.0, 0.0), (0.0, 0.0)]).until(10.0)
    assert list(flow.stopped) == [0]
    assert "rolls or slides" in flow.stopped[0]
    assert flow.places[1] == pytest.approx([5.0, 0.5 * 9.81 * 100.0], rel=1e-14)
    lost = launch(box(), [(0.0, 0.0), (9.0, 9.0)], [(1.0, 0.0), (1e3, 0.0)]).until(1e6, 100)
    assert lost.stopped[0].startswith("impact limit")
    assert lost.stopped[1].startswith("escaped")
    assert lost.impacts.tolist() == [100, 0]


def test_what_cannot_be_launched_is_named() -> None:
    for places, velocities, words in (
        ([(0.0, 0.0)], [(1.0, 0.0)], "inside of a peg"),
        ([(2.3, 0.1)], [(1.0, 0.0)], "inside of a peg"),
        ([(math.nan, 0.0)], [(1.0, 0.0)], "places: "),
        ([(1.15, 0.0)], [(1.0, math.inf)], "velocities: "),
        ([(1.15, 0.0)], [(1.0, 0.0), (1.0, 0.0)], "1 places for 2 velocities"),
        ([1.15, 0.0], [(1.0, 0.0)], "shape"),
    ):
        with pytest.raises(ParameterError, match=words):
            launch(lattice(), places, velocities)
    flow = launch(lattice(), PLACES, VELOCITIES).until(1.0)
    with pytest.raises(ParameterError, match=r"time 0.5 is not from 1"):
        flow.until(0.5)
    with pytest.raises(ParameterError, match="tangents=True"):
        _ = flow.growth
