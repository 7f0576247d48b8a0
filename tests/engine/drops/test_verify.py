"""Verifying a record reproduces it bit for bit, or names the first field that differs."""

import copy
import json
import math
from typing import Any

import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.engine import Board, RecordError, drop, verify
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.parameters import SolverName

TRIANGLE = Board.preset("triangle-16")
NO_BOARDS: list[object] = ["no-such-board", {"pegs": 3}, None, 7, []]
NO_IMPACTS: list[object] = [None, "many", {}, [1, 2]]


def record(**options: Any) -> dict[str, Any]:
    """A record after a round trip through JSON."""
    found: dict[str, Any] = json.loads(json.dumps(drop(TRIANGLE, 42, **options).to_dict()))
    return found


@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_every_record_verifies_after_a_round_trip_through_json(solver: SolverName) -> None:
    boards = [Board.preset("triangle-8-low"), Board.preset("classic"), Board.preset("galton")]
    boards += [scene(name).board for name in scene_names() if name != "shelf"]
    for board in boards:
        text = json.dumps(drop(board, 7, solver=solver).to_dict())
        result = verify(json.loads(text))
        assert result.ok
        assert (result.field, result.expected, result.actual) == (None, None, None)


def test_a_record_without_a_seed_verifies_by_its_start() -> None:
    given = drop(scene("ramp").board, x=-0.8).to_dict()
    assert verify(json.loads(json.dumps(given))).ok


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("board_digest", "0" * 64),
        ("physics_version", PHYSICS_VERSION + 1),
        ("bin", 0),
        ("score", 1000.0),
        ("duration", 1.0),
        ("x_end", 0.0),
        ("digest", "f" * 64),
    ],
)
def test_a_changed_field_is_named_with_both_values(field: str, value: object) -> None:
    changed = record() | {field: value}
    result = verify(changed)
    assert (result.ok, result.field, result.expected) == (False, field, value)
    assert result.actual == record()[field]


@pytest.mark.parametrize("column", range(8))
def test_one_unit_in_the_last_place_of_one_impact_is_seen(column: int) -> None:
    changed = record()
    row = changed["impacts"][5]
    row[column] = math.nextafter(row[column], math.inf) if column < 6 else row[column] + 1
    result = verify(changed)
    assert (result.ok, result.field) == (False, "impacts[5]")
    assert result.expected == row
    assert result.actual == record()["impacts"][5]


def test_a_lost_impact_is_seen() -> None:
    changed = record()
    del changed["impacts"][3]
    count = len(changed["impacts"])
    result = verify(changed)
    assert (result.ok, result.field) == (False, "impacts")
    assert (result.expected, result.actual) == (f"{count} impacts", f"{count + 1} impacts")


def test_a_record_may_leave_out_what_it_does_not_claim() -> None:
    short = {
        key: value
        for key, value in record().items()
        if key in {"board", "board_digest", "seed", "solver", "physics_version", "digest"}
    }
    assert verify(short).ok


@pytest.mark.parametrize(
    "field", ["board", "board_digest", "seed", "solver", "physics_version", "digest"]
)
def test_a_record_that_lacks_a_field_is_malformed(field: str) -> None:
    broken = record()
    del broken[field]
    with pytest.raises(RecordError, match=field) as caught:
        verify(broken)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("board", bad) for bad in NO_BOARDS),
        *(("seed", bad) for bad in ("-1", 1.5, None)),
        *(("solver", bad) for bad in ("magic", None, ["exact"])),
        *(("x", bad) for bad in ("left", 1e9, True)),
    ],
)
def test_a_record_that_cannot_be_played_is_malformed(field: str, value: object) -> None:
    with pytest.raises(RecordError):
        verify(record() | {field: value})


@pytest.mark.parametrize(
    ("field", "value"),
    [("dt", 0.0), ("dt", None), ("substeps", 2.5), ("substeps", "4"), ("correction", 2.0)],
)
def test_a_stepped_record_with_bad_parameters_is_malformed(field: str, value: object) -> None:
    with pytest.raises(RecordError) as caught:
        verify(record(solver="stepped") | {field: value})
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("impacts", bad) for bad in NO_IMPACTS),
        *(("duration", None), ("bin", "seven"), ("score", math.nan)),
        *(("physics_version", None), ("board_digest", 5), ("digest", None)),
    ],
)
def test_a_claim_of_the_wrong_kind_is_a_claim_that_differs(field: str, value: object) -> None:
    result = verify(record() | {field: value})
    assert not result.ok
    assert result.field == field


@pytest.mark.parametrize("whole", [None, [], "record", 3])
def test_a_record_that_is_not_an_object_is_malformed(whole: Any) -> None:
    with pytest.raises(RecordError):
        verify(whole)


def test_verifying_changes_nothing_of_the_record() -> None:
    given = record()
    kept = copy.deepcopy(given)
    verify(given)
    assert given == kept
