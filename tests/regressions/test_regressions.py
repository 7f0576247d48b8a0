"""Saved states that once went wrong: the ball passes through no surface, and its drop ends."""

import json
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from plinko.engine import Board, drop
from tests.engine.exact.test_exact import NEAR, overlap

STATES = sorted(Path(__file__).parent.glob("*.json"))


@pytest.mark.parametrize("path", STATES, ids=[path.stem for path in STATES])
def test_a_ball_ends_as_it_should(path: Path) -> None:
    saved = json.loads(path.read_text(encoding="utf-8"))
    with mock.patch(
        "plinko.engine.board.checks.playable.check"
    ):  # some are traps, which the validator refuses
        board = Board.from_json(saved["board"])
    found = drop(board, x=saved["x"], solver=saved["solver"])
    assert found.bin == saved["bin"], saved["about"]
    assert (found.unsettled is not None) is saved["unsettled"], saved["about"]
    assert len(found.impacts) < 1000, saved["about"]
    impacts = found.impacts
    assert (np.diff(impacts["t"]) >= 0.0).all()
    assert overlap(board, impacts["x"], impacts["y"]) <= NEAR, saved["about"]
    states = found.states(np.linspace(0.0, min(found.duration, 20.0), 4000))
    assert overlap(board, states["x"], states["y"]) <= NEAR, saved["about"]


def test_there_are_saved_states() -> None:
    assert len(STATES) >= 7
