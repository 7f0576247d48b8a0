"""A log's digest covers every field, or the field is refused; also in the first version."""

import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest
import rfc8785
from hypothesis import example, given
from hypothesis import strategies as st

from plinko.app.protocol.visitors import TAG_FIELDS
from plinko.app.rooms.canonical import LARGEST, canonical
from plinko.app.rooms.log import verify_log
from plinko.engine import Drop, RecordError, drop, verify
from plinko.engine.drops.verify import Verification
from tests.app.rooms.logs import LOGS, Log, of_scene

Path = tuple[str | int, ...]


def paths(value: Any, here: Path = ()) -> Iterator[Path]:
    """The paths of all numbers, strings, booleans and nulls in a JSON value."""
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from paths(part, (*here, key))
    else:
        yield here


def objects(value: Any, here: Path = ()) -> Iterator[Path]:
    """The paths of all objects in a JSON value."""
    if isinstance(value, dict | list):
        if isinstance(value, dict):
            yield here
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from objects(part, (*here, key))


def at(value: Any, path: Path) -> Any:
    for key in path:
        value = value[key]
    return value


def other(value: Any) -> Any:
    """The nearest other value of the same type."""
    match value:
        case None:
            return "someone"
        case bool():
            return not value
        case int():
            return value + 1
        case float():
            return value * (1 + 2**-52) if value else 2.0**-40
        case str():
            return f"{value[:-1]}{'1' if value[-1:] == '0' else '0'}"
    raise AssertionError(value)


def holds(log: Log) -> bool:
    try:
        return verify_log(log).ok
    except RecordError:
        return False


@pytest.mark.parametrize("kind", LOGS)
def test_a_log_holds_after_a_round_trip_through_json(kind: str) -> None:
    log = LOGS[kind]()
    assert log["version"] == 2
    assert verify_log(log) == verify_log(json.loads(json.dumps(log))) == Verification(True)
    if kind == "drops":
        told = [(each["stake"], each["who"]) for each in log["drops"]]
        assert told == [(100, "ann"), (0, "ben"), (0, None), (7, "ann")]


@pytest.mark.parametrize("kind", LOGS)
def test_every_field_of_a_log_but_a_tag_is_covered_or_refused(kind: str) -> None:
    log = LOGS[kind]()
    places = list(paths(log))
    assert {"who", "tick_rate", "room"} <= {path[-1] for path in places}
    unseen = []
    for path in places:
        changed = copy.deepcopy(log)
        at(changed, path[:-1])[path[-1]] = other(at(log, path))
        if holds(changed):
            unseen.append(path)
    assert [path for path in unseen if path[0] != "drops" or path[-1] not in TAG_FIELDS] == []


@pytest.mark.parametrize("kind", LOGS)
def test_a_log_with_another_field_or_without_one_but_a_tag_does_not_hold(kind: str) -> None:
    log = LOGS[kind]()
    for path in objects(log):
        changed = copy.deepcopy(log)
        at(changed, path)["note"] = 1
        with pytest.raises(RecordError, match=r"note|unknown"):
            verify_log(changed)
        for name in at(log, path):
            changed = copy.deepcopy(log)
            del at(changed, path)[name]
            assert holds(changed) is (name in TAG_FIELDS and path[:1] == ("drops",)), (*path, name)


def touched(kind: str, path: Path, value: Any) -> Log:
    """The log with another value at a place."""
    log = LOGS[kind]()
    at(log, path[:-1])[path[-1]] = value
    return log


@pytest.mark.parametrize(
    ("kind", "path", "value", "field"),
    [
        ("drops", ("drops", 0, "result", "digest"), "0" * 64, "drops[0].result.digest"),
        ("drops", ("drops", 0, "result", "bin"), 7, "drops[0].result.bin"),
        ("drops", ("drops", 0, "result", "tick"), 10**6, "drops[0].result.tick"),
        ("drops", ("drops", 0, "result"), None, "drops[0].result"),
        ("drops", ("world_digest",), "0" * 64, "world_digest"),
        ("drops", ("digest",), "0" * 64, "digest"),
        ("drops", ("physics_version",), 0, "physics_version"),
        ("drops", ("board",), "triangle-8", "board_digest"),
        ("board", ("inputs", 2, "input", "vx"), 1.0000001, "world_digest"),
        ("scene", ("physics_version",), 0, "physics_version"),
    ],
)
def test_a_verdict_names_what_was_changed(kind: str, path: Path, value: Any, field: str) -> None:
    verdict = verify_log(touched(kind, path, value))
    assert (verdict.ok, verdict.field) == (False, field)


@pytest.mark.parametrize(
    ("kind", "path", "value", "field", "says"),
    [
        ("drops", ("tick",), None, "tick", "tick"),
        ("drops", ("drops", 1, "ball"), 5, "drops[1].ball", "ball"),
        ("drops", ("drops", 1, "tick"), -1, "drops[1].tick", "-1"),
        ("drops", ("drops", 1, "seed"), "-3", "drops[1]", "-3"),
        ("drops", ("drops",), 7, "drops", "drops"),
        ("scene", ("inputs", 0, "input"), {"type": "fly"}, "inputs[0].input", "fly"),
        ("board", ("inputs", 2, "input", "vx"), "1", "inputs[2].input", "not a number"),
        ("board", ("inputs", 2, "input", "ref"), 1, "inputs[2].input", "no `ref`"),
        ("scene", ("inputs", 0, "tick"), 999_999, "tick", "inputs[0].tick 999999 is after"),
    ],
)
def test_a_log_that_cannot_be_replayed_is_refused_by_what_is_wrong(
    kind: str, path: Path, value: Any, field: str, says: str
) -> None:
    with pytest.raises(RecordError) as refused:
        verify_log(touched(kind, path, value))
    assert refused.value.field == field
    assert says in str(refused.value)


def test_a_log_that_ends_too_early_or_has_a_board_and_a_scene_does_not_hold() -> None:
    for kind, name in (("drops", "drops"), ("scene", "inputs")):
        assert not holds(touched(kind, (name,), LOGS[kind]()[name][:-1]))
    with pytest.raises(RecordError, match="either a board or a scene"):
        verify_log(of_scene() | {"board": "triangle-8"})


@pytest.mark.parametrize("kind", LOGS)
def test_an_impossible_mark_is_refused_and_another_version_is_no_proof(kind: str) -> None:
    log = LOGS[kind]()
    for version in (1, 3):
        assert verify_log({**log, "version": version}).field == "version"
    for who in ("", "x" * 65, 5):
        log["drops" if kind == "drops" else "inputs"][0]["who"] = who
        with pytest.raises(RecordError, match="who"):
            verify_log(log)


# The canonical form.

NUMBERS = st.floats(-LARGEST, LARGEST, exclude_min=True, exclude_max=True)
JSON = st.recursive(
    st.none() | st.booleans() | st.text() | st.integers(-(2**53) + 1, 2**53 - 1) | NUMBERS,
    lambda parts: st.lists(parts) | st.dictionaries(st.text("abcxyz_019"), parts),
)


@given(JSON)
@example(1.0577017964096304e-06)  # JavaScript uses an exponent only below 1e-6
@example([1e-6, -9.999999999999999e-06, 1e-5, 9.999999999999999e-07])
def test_the_canonical_form_is_that_of_rfc_8785(value: Any) -> None:
    assert canonical(value) == rfc8785.dumps(value)


def test_a_number_that_no_log_holds_is_refused_and_integers_are_written_in_full() -> None:
    for number in (float("inf"), float("nan"), 2.0**53, -1e300):
        with pytest.raises(RecordError, match="not within"):
            canonical([{"x": number}])
    assert canonical(10**18 + 1) == b"1000000000000000001"


# Records of single drops.


def records() -> dict[str, Drop]:
    return {
        "seed": drop("triangle-8", 1),
        "x": drop("triangle-8", 1, x=0.1),
        "stepped": drop("triangle-8", 1, solver="stepped", dt=0.01, substeps=3),
    }


@pytest.mark.parametrize("kind", records())
def test_every_field_of_a_record_is_covered_or_refused(kind: str) -> None:
    record = records()[kind].to_dict(certainty=kind != "stepped")
    assert verify(record).ok
    unseen = []
    for path in paths(record):
        changed = copy.deepcopy(record)
        at(changed, path[:-1])[path[-1]] = other(at(record, path))
        try:
            if verify(changed).ok:
                unseen.append(path)
        except RecordError:
            continue
    # With an explicit x the seed has no effect.
    assert unseen == ([("seed",)] if kind == "x" else [])
    with pytest.raises(RecordError, match="note"):
        verify(record | {"note": 1})


def test_a_time_step_with_the_exact_solver_is_refused() -> None:
    record = drop("triangle-8", 1).to_dict()
    assert verify(record | {"dt": None}).ok, "a client that writes every field writes null"
    with pytest.raises(RecordError, match="dt belongs to the stepped solver"):
        verify(record | {"dt": 0.01})
