"""The certainty of a drop: its tangents agree with the oracle, and certain bins are right."""

import math

import numpy as np
import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.engine import Board, Drop, ParameterError, drop
from plinko.engine.constants import KIND_CONTACT_CHANGE, KIND_NAMES
from plinko.engine.drops.certainty import certainty_of
from plinko.engine.drops.start import start_of
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.parameters import Exact
from tests.long import many
from tools.oracle import golden, oracle_drop
from tools.oracle.scenes import accuracy_boards

BLURRED = 1e8
"""Growth beyond which rounding of the path itself affects six digits of the tangent."""

BOARDS = sorted(accuracy_boards())


def start_in(name: str) -> float:
    shown = scene(name)
    return start_of(shown.board, 7, None) if shown.x is None else shown.x


SLOW = {"apex", "dead", "zigzag"}  # the oracle's drops there take half a second


@pytest.mark.parametrize("name", [many(name) if name in SLOW else name for name in scene_names()])
def test_places_move_with_the_start_as_two_runs_of_the_oracle_do(name: str) -> None:
    board, x = scene(name).board, start_in(name)
    found = certainty_of(follow(board, at_start(board, x), Exact()))
    expected = oracle_drop(board, x).amplifications
    compared = 0
    for mine, theirs in zip(found.growth, expected, strict=False):
        if not theirs < BLURRED:
            break
        assert mine == pytest.approx(theirs, rel=1e-3, abs=1e-9)
        compared += 1
    assert compared >= min(len(expected), 8)


def test_the_scenes_lead_tangents_through_every_kind_of_event() -> None:
    kinds = {int(k) for name in scene_names() for k in drop_in(name).impacts["kind"]}
    assert kinds == set(range(len(KIND_NAMES)))


def drop_in(name: str) -> Drop:
    return drop(scene(name).board, x=start_in(name))


def test_whatever_the_start_a_ball_leaves_a_wall_at_its_end() -> None:
    found = drop_in("ramp")
    at = [i for i, k in enumerate(found.impacts["kind"]) if k == KIND_CONTACT_CHANGE]
    assert found.certainty.growth[at[-1]] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("name", BOARDS)
def test_the_estimated_error_covers_the_true_one_and_what_is_certain_is_right(name: str) -> None:
    """The error of the landing's x, in every drop that double precision can decide."""
    board = accuracy_boards()[name]
    drops = golden.load(name)[1]
    ratios = []
    certain = 0
    for kept in drops:
        found = drop(board, x=kept.x)
        if golden.decidable(kept, board):
            assert found.certainty.error is not None
            ratios.append(abs(float(kept.end - found.x_end)) / found.certainty.error)
        if found.certain:
            certain += 1
            assert found.bin == kept.bin
    assert certain >= (0.7 if board.drag > 0.0 else 0.1) * len(drops)
    assert max(ratios) < 16.0  # engine.drops.certainty.MARGIN
    assert 0.01 < np.median(ratios) < 1.0  # the estimate must not be far too large either


def test_a_certain_bin_stays_when_the_start_moves_by_a_step() -> None:
    board = Board.preset("triangle-12")
    certain = 0
    for seed in range(200):
        found = drop(board, seed)
        if not found.certain:
            continue
        certain += 1
        for way in (-math.inf, math.inf):
            assert drop(board, x=math.nextafter(found.x_start, way)).bin == found.bin
    assert certain >= 100


def test_a_long_chaotic_drop_is_not_certain() -> None:
    """Without drag a ball bounces so long that half an ulp grows to the size of the board."""
    board = scene("elastic").board
    assert not drop_in("elastic").certain
    grown = drop(board, x=start_in("elastic")).amplification
    assert grown is not None
    assert grown * math.ulp(board.ball.radius) > board.ball.radius


def test_a_drop_that_never_lands_is_not_certain() -> None:
    found = drop(scene("shelf").board, x=0.0)
    assert (found.amplification, found.certainty.error, found.certain) == (None, None, False)


def test_growth_is_mirrored_exactly() -> None:
    board = Board.preset("triangle-16")
    for x in (0.01, 0.0775):
        left, right = drop(board, x=-x).certainty, drop(board, x=x).certainty
        assert left.growth.tolist() == right.growth.tolist()
        assert left.errors.tolist() == right.errors.tolist()


def test_tangents_change_nothing_of_the_drop() -> None:
    board = Board.preset("triangle-8")
    with_tangent, without = drop(board, 42), drop(board, 42)
    assert with_tangent.amplification is not None
    assert with_tangent.digest == without.digest
    assert with_tangent.to_dict(certainty=True).items() > without.to_dict().items()


def test_the_stepped_solver_does_not_claim_to_know() -> None:
    found = drop(Board.preset("triangle-8"), 42, solver="stepped")
    with pytest.raises(ParameterError, match="cannot tell how certain a bin is: use 'exact'"):
        _ = found.certain
