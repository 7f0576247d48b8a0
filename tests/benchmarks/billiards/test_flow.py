"""Many balls of a billiard, on boards that are open and that repeat."""

import math

import numpy as np
import pytest

from benchmarks.billiards import launch, path
from plinko.engine.errors import ParameterError
from plinko.engine.physics import body
from tests.benchmarks.billiards.scenes import CELL, lattice, patch

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
