"""One ball of a billiard, followed by the exact solver until a given instant."""

import numpy as np
import pytest

from benchmarks.billiards import Billiard, path
from plinko.engine import Board, drop
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Peg, Wall
from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_PEG
from plinko.engine.errors import ParameterError
from plinko.engine.exact.outcome import BALANCED, EVENT_LIMIT, TIME_LIMIT
from plinko.engine.physics import body
from tests.benchmarks.billiards.scenes import box, lattice, patch

ROUGH = Material(0.1, 0.3)


def billiard_of(board: BoardFields, material: Material) -> Billiard:
    return Billiard(
        pegs=board.pegs, walls=board.walls, ball=board.ball, material=material,
        gravity=board.gravity, drag=board.drag,
    )  # fmt: skip


def test_a_ball_that_nothing_pulls_flies_straight() -> None:
    end = path(Billiard(), (0.1, 0.2), (3.0, -4.0), 2.0, spin=5.0).end
    assert end.tolist() == [2.0, 6.1, -7.8, 3.0, -4.0, 10.0, 5.0]


def test_a_dropped_ball_takes_the_drop_s_path_bit_for_bit() -> None:
    board = Board.preset("triangle-8")
    assert board.peg_material == board.wall_material
    played = drop(board, seed=7)
    impacts = played.trajectory.events[:-1]  # the last is the landing
    last = float(impacts[-1, 0])
    found = path(
        billiard_of(board, board.peg_material), (played.x_start, board.drop.y), (0.0, 0.0), last
    )
    assert found.events.tobytes() == impacts.tobytes()
    assert len(impacts) > 10


def test_a_path_to_an_earlier_instant_begins_the_longer_one() -> None:
    board = Billiard(
        pegs=(Peg(0.0, 0.0, 0.4),),
        ball=BallSpec(radius=0.1, restitution=0.1, friction=0.3),
        material=ROUGH,
        gravity=9.81,
    )
    whole = path(board, (0.01, -1.0), (0.0, 0.0), 3.0)
    assert KIND_CONTACT_BEGIN in whole.marks[:, 0], "it slides off the peg after some bounces"
    first, last = float(whole.events[0, 0]), float(whole.events[-1, 0])
    for until in np.linspace(0.5 * first, 1.1 * last, 40).tolist():
        part = path(board, (0.01, -1.0), (0.0, 0.0), until)
        assert part.end.tobytes() == whole.states_at(np.array([until]))[0].tobytes()
        assert part.end[body.T] == until
        assert part.events.tobytes() == whole.events[whole.events[:, 0] <= until].tobytes()
        assert part.outcome == TIME_LIMIT


def test_a_ball_between_walls_is_where_reflection_folds_it_to() -> None:
    found = path(box(2.0), (0.0, 0.0), (3.0, 0.0), 6.9)
    assert found.end[[body.X, body.VX]].tolist() == pytest.approx([0.7, 3.0], abs=1e-12)
    assert len(found.events) == 10
    turned = path(box(2.0), (0.0, 0.5), (3.0, 0.0), 6.5)
    assert turned.end[[body.X, body.Y]].tolist() == pytest.approx([-0.5, 0.5], abs=1e-12)


def test_a_path_ends_in_time_however_often_the_ball_bounces() -> None:
    """In a gap of a millimetre, the whole path is one stretch of the solver's search."""
    narrow = path(box(1e-3), (0.0, 0.0), (1.0, 0.0), 1.0)
    assert narrow.end[body.T] == 1.0
    assert len(narrow.events) == 1000
    assert path(box(1e-3), (0.0, 0.0), (1.0, 0.0), 1.0, max_events=300).outcome == EVENT_LIMIT
    few = path(box(1e-3), (0.0, 0.0), (1.0, 0.0), 0.0042)
    assert few.outcome == TIME_LIMIT
    assert len(few.events) == 4


def test_a_ball_that_comes_to_rest_stays_there() -> None:
    floor = Billiard(
        walls=(Wall(-1.0, 1.0, 1.0, 1.0),), ball=BallSpec(radius=0.1, restitution=0.0),
        material=Material(0.0, 0.0), gravity=9.81,
    )  # fmt: skip
    found = path(floor, (0.0, 0.0), (0.0, 0.0), 100.0)
    assert found.outcome == BALANCED
    assert found.end[body.Y] == pytest.approx(0.9, abs=1e-15)


def test_every_peg_that_is_hit_is_named() -> None:
    found = path(patch(3), (1.15, 0.0), (1.0, 0.1), 5.0)
    assert set(found.marks[:, 0].tolist()) == {KIND_PEG}
    assert len(found.events) > 3


def test_what_a_path_cannot_begin_with_is_named() -> None:
    with pytest.raises(ParameterError, match="launch") as error:
        path(lattice(), (1.15, 0.0), (1.0, 0.0), 1.0)
    assert error.value.field == "billiard"
    with pytest.raises(ParameterError, match=r"velocity\[1\] nan"):
        path(box(), (0.0, 0.0), (1.0, float("nan")), 1.0)
    with pytest.raises(ParameterError, match="until -1"):
        path(box(), (0.0, 0.0), (1.0, 0.0), -1.0)
