"""One ball of a billiard, followed by the exact solver until a given instant."""

import numpy as np
import pytest

from benchmarks.billiards import Billiard, path
from plinko.engine import Board, drop
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Peg
from plinko.engine.constants import KIND_CONTACT_BEGIN
from plinko.engine.errors import ParameterError
from plinko.engine.exact.outcome import TIME_LIMIT
from plinko.engine.physics import body
from tests.benchmarks.billiards.scenes import box, lattice

ROUGH = Material(0.1, 0.3)


def billiard_of(board: BoardFields, material: Material) -> Billiard:
    return Billiard(
        pegs=board.pegs, walls=board.walls, ball=board.ball, material=material,
        gravity=board.gravity, drag=board.drag,
    )  # fmt: skip


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


def test_what_a_path_cannot_begin_with_is_named() -> None:
    with pytest.raises(ParameterError, match="launch") as error:
        path(lattice(), (1.15, 0.0), (1.0, 0.0), 1.0)
    assert error.value.field == "billiard"
    with pytest.raises(ParameterError, match=r"velocity\[1\] nan"):
        path(box(), (0.0, 0.0), (1.0, float("nan")), 1.0)
    with pytest.raises(ParameterError, match="until -1"):
        path(box(), (0.0, 0.0), (1.0, 0.0), -1.0)
