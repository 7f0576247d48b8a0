"""Drops on hard boards that once did not end, with the landing that the stepped solver finds.

The JSON files have one drop per line. The stepped solver with steps of 1/1000 s and 5 substeps and
with 1/2000 s and 10 substeps agreed on each drop within 4 mm, and on nearly all within 0.1 mm.
x_end and duration are those of the finer steps.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from plinko.engine import Board, drop

FILES = sorted((Path(__file__).parent / "contacts").glob("*.json"))

X, T = 1e-3, 5e-3  # m and s: error of the time steps


def cases() -> list[Any]:
    return [
        pytest.param(case, id=f"{path.stem}-{row}")
        for path in FILES
        for row, case in enumerate(json.loads(path.read_text(encoding="utf-8")))
    ]


@pytest.mark.parametrize("case", cases())
def test_a_ball_lands_where_steps_lead_it(case: dict[str, Any]) -> None:
    found = drop(Board.from_json(case["board"]), case["seed"])
    assert (found.bin, found.unsettled) == (case["bin"], None)
    assert found.x_end == pytest.approx(case["x_end"], abs=X)
    assert found.duration == pytest.approx(case["duration"], abs=T)
    assert len(found.impacts) < 1000


def test_there_are_cases_of_each_kind() -> None:
    assert {path.stem for path in FILES} == {
        "corners", "funnels", "notches", "overhangs", "shelves", "two-contacts",
    }  # fmt: skip
