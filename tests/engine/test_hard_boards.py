"""Balls on hard boards land, and where time steps and proofs say."""

import json
from itertools import islice

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings

from plinko.engine import Board, certify, drop, drop_many
from plinko.engine.drops.batch import DropBatch
from plinko.engine.exact.outcome import BALANCED, LANDED, REASONS, WEDGED
from tests.long import tries
from tools.boards.hard_boards import KINDS, HardBoard, hard_board, hard_boards, numbered

DROPS = 50
"""Drops on each board; with all boards of all kinds, `make test-long` plays a million."""

BOARDS = tries(6, 1 + 1_000_000 // (DROPS * len(KINDS)))

ALIKE = 1e-3
"""m; a drop is compared only if x_end differs by less between the two step sizes.

Near an edge, the smallest error of a step decides on which side a ball passes, and the steps say
nothing about the exact path. The two step sizes then mostly end at different places. If they agree
to a millimetre, their error has grown to a few millimetres at most."""

NEAR = 5e-3
"""m; largest allowed difference between the exact x_end and that of the steps."""

STEPPED_DRAG = 20.0
"""1/s; with more drag a flight takes minutes, and so does computing its steps."""


def played(kind: str, count: int) -> list[tuple[HardBoard, Board]]:
    """The first `count` playable boards of a kind."""
    boards = ((hard, hard.playable()) for hard in numbered(kind))
    return list(islice(((hard, board) for hard, board in boards if board is not None), count))


def dropped(hard: HardBoard, board: Board) -> list[DropBatch]:
    """Drops by seed, and from the starts that aim at the hard parts."""
    batches = [drop_many(board, range(DROPS))]
    if hard.starts:
        batches.append(drop_many(board, range(len(hard.starts)), xs=hard.starts))
    return batches


def check_ends(batch: DropBatch) -> None:
    """Assert that every ball lands, or is proven to stay where it lies."""
    for i in np.flatnonzero(batch.outcome != LANDED).tolist():
        where = (json.dumps(batch.board.to_dict()), float(batch.x_start[i]))
        assert batch.outcome[i] in {BALANCED, WEDGED}, (REASONS[batch.outcome[i]], *where)
        proof = certify(batch.board, x=float(batch.x_start[i]))
        assert proof.unsettled == REASONS[batch.outcome[i]], where


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_every_ball_on_a_hard_board_lands_or_is_proven_to_rest(kind: str) -> None:
    for hard, board in played(kind, BOARDS):
        for batch in dropped(hard, board):
            check_ends(batch)


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(hard_boards)
def test_a_ball_lands_on_any_hard_board(hard: HardBoard) -> None:
    board = hard.playable()
    assume(board is not None)
    assert board is not None
    check_ends(drop_many(board, range(8)))


@pytest.mark.parametrize("kind", KINDS)
def test_most_hard_boards_may_be_played(kind: str) -> None:
    """Otherwise the other tests would have little to test."""
    made = [hard_board(kind, number) for number in range(16)]
    assert sum(hard.playable() is not None for hard in made) > 8


@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "treacle"])
def test_a_ball_goes_where_steps_in_time_lead_it(kind: str) -> None:
    """Two step sizes are computed; drops on which they disagree are not compared."""
    compared = odd = count = 0
    for _, board in played(kind, tries(4, 100)):
        if board.drag > STEPPED_DRAG:
            continue
        seeds = range(10)
        exact = drop_many(board, seeds)
        coarse = drop_many(board, seeds, solver="stepped", dt=1 / 1000, substeps=5)
        fine = drop_many(board, seeds, solver="stepped", dt=1 / 2000, substeps=10)
        alike = (coarse.bin == fine.bin) & (fine.bin >= 0)
        alike &= np.abs(coarse.x_end - fine.x_end) <= ALIKE
        near = (exact.outcome == LANDED) & (np.abs(exact.x_end - fine.x_end) <= NEAR)
        for i in np.flatnonzero(alike & ~near).tolist():
            # Both step sizes may err alike by chance, as in one of 800 drops into funnels.
            proof, where = certify(board, i), (json.dumps(board.to_dict()), i)
            assert proof.bin == exact.bin[i], where
            assert proof.x_end is not None
            assert proof.x_end.low - 1e-6 <= exact.x_end[i] <= proof.x_end.high + 1e-6, where
            odd += 1
        compared += int(alike.sum())
        count += len(alike)
    assert compared > 0.9 * count > 0
    assert odd <= 0.005 * compared


@pytest.mark.long
@pytest.mark.parametrize("kind", tries([kind for kind in KINDS if kind != "treacle"], [*KINDS]))
def test_a_ball_lands_where_it_is_proven_to(kind: str) -> None:
    for hard, board in played(kind, tries(1, 30)):
        starts = [drop(board, seed).x_start for seed in range(tries(1, 5))]
        for x in (*starts, *hard.starts[: tries(1, 5)]):
            proof, made = certify(board, x=x), drop(board, x=x)
            where = (json.dumps(hard.form), x, proof.undecided)
            assert proof.decided, where
            assert (proof.bin, proof.unsettled) == (made.bin, made.unsettled), where
