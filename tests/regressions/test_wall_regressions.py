"""Drops on walls that once went wrong, with the landing that `plinko certify` has proven.

The file has one drop per line: a wall in one piece, the same in two, a ramp on which contact once
passed between two pieces for ever, a board with an impact where no peg is, two bends by so little
that rounding hides whether a ball comes out from behind the next wall's line, and two walls with a
gap of 1e-15 m.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from plinko.engine import Board, drop
from tools.boards.checked_drops import check_starts

CASES = json.loads((Path(__file__).parent / "walls" / "seams.json").read_text("utf-8"))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_a_ball_keeps_to_the_surface_and_lands_where_its_proof_says(case: dict[str, Any]) -> None:
    board = Board.from_json(case["board"])
    found = drop(board, case.get("seed"), x=case.get("x"))
    assert (found.bin, found.unsettled) == (case["bin"], None)
    assert found.x_end == pytest.approx(case["x_end"], abs=1e-9)
    assert check_starts(board, [found.x_start]) == []
