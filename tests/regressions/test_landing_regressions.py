"""Drops that once went wrong, with the landing that another solver finds.

`contacts/` has drops on hard boards that did not end. The stepped solver with steps of 1/1000 s and
5 substeps and with 1/2000 s and 10 substeps agreed on each within 4 mm, and on nearly all within
0.1 mm. x_end and duration are those of the finer steps.

`walls/` has drops whose landing `plinko certify` has proven: a wall in one piece, the same in two,
a ramp on which contact once passed between two pieces for ever, a board with an impact where no peg
is, two bends by so little that rounding hides whether a ball comes out from behind the next wall's
line, and two walls with a gap of 1e-15 m.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from plinko.engine import Board, drop
from tools.boards.checked_drops import check_starts

FOLDER = Path(__file__).parent
FILES = [*sorted(FOLDER.glob("contacts/*.json")), FOLDER / "walls/seams.json"]

X, T = 1e-3, 5e-3  # m and s: error of the time steps
PROVEN = 1e-9


def cases() -> list[Any]:
    return [
        pytest.param(case, id=case.get("name", f"{path.stem}-{row}"))
        for path in FILES
        for row, case in enumerate(json.loads(path.read_text(encoding="utf-8")))
    ]


@pytest.mark.parametrize("case", cases())
def test_a_ball_lands_where_another_solver_says(case: dict[str, Any]) -> None:
    board = Board.from_json(case["board"])
    found = drop(board, case.get("seed"), x=case.get("x"))
    assert (found.bin, found.unsettled) == (case["bin"], None)
    assert found.x_end == pytest.approx(case["x_end"], abs=X if "duration" in case else PROVEN)
    assert found.duration == pytest.approx(case.get("duration", found.duration), abs=T)
    assert len(found.impacts) < 1000
    assert check_starts(board, [found.x_start]) == [], "it keeps to the surface"


def test_there_are_cases_of_each_kind() -> None:
    assert {path.stem for path in FILES} == {
        *("corners", "funnels", "notches", "overhangs", "shelves", "two-contacts", "seams"),
    }
