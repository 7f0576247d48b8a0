"""Logs and records survive JavaScript, which writes 1.0 as 1, and a page checks logs."""

import json
from copy import deepcopy
from typing import Any

import pytest

from plinko.app.rooms.drop_format import ENTRY, ENTRY_OPTIONAL, RESULT, DropFormat
from plinko.app.rooms.log import verify_log
from plinko.app.rooms.stakes import most_stake, payout_of
from plinko.engine import drop, verify
from plinko.engine.parameters import SolverName
from tests.app.rooms.logs import LOGS
from tests.js.conftest import MODULES, Run
from tests.js.solver.test_solver import opened
from tools import log_fields


def rewritten(run: Run, value: Any) -> Any:
    """`value` after JavaScript has parsed and written it."""
    return run("util/doubles.js", "(_, value) => value", value)


def test_logs_that_javascript_has_rewritten_are_valid(run: Run) -> None:
    logs = {kind: make() for kind, make in LOGS.items()}
    again = rewritten(run, logs)
    for kind, log in again.items():
        assert json.dumps(log) != json.dumps(logs[kind]), "no number lost its .0"
        assert verify_log(log).ok, kind


@pytest.mark.parametrize("options", [{"seed": 2**64 - 1}, {"x": 0.0625}])
@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_records_that_javascript_has_rewritten_are_valid(
    run: Run, options: dict[str, Any], solver: SolverName
) -> None:
    record = drop("triangle-8", solver=solver, **options).to_dict()
    assert verify(rewritten(run, record)).ok


def compared(run: Run, *logs: Any) -> list[Any]:
    """Compare logs in the page: for each the field that differs, None, or the error."""
    compare = """
    const { compareLog, readJson } = await load();
    const say = async (text) => {
      const log = readJson(text);
      try {
        return (await compareLog(solver, log, log.board))?.field ?? null;
      } catch (error) {
        return `${error.name}: ${error.field}`;
      }
    };
    return Promise.all(given.map(say));
    """
    parts = "{ ...(await import(LOG)), ...(await import(JSON_TEXT)) }"
    for name, path in (("LOG", "log/log.js"), ("JSON_TEXT", "input/json-text.js")):
        parts = parts.replace(name, json.dumps(f"{MODULES.as_uri()}/solver/{path}"))
    function = opened(f"const load = async () => ({parts}); {compare}")
    return run("solver/solver.js", function, [json.dumps(log) for log in logs])  # type: ignore[no-any-return]


def altered(log: Any, *path: Any, to: Any) -> Any:
    """Return a copy of the log with another value at `path`."""
    copy = deepcopy(log)
    place = copy
    for key in path[:-1]:
        place = place[key]
    assert place.get(path[-1]) != to
    place[path[-1]] = to
    return copy


def test_a_page_reproduces_a_room_s_log_to_the_last_bit(run: Run) -> None:
    log = LOGS["drops"]()
    late = next(i for i, each in enumerate(log["drops"]) if each["result"] is None)
    wrong = {
        "version": altered(log, "version", to=1),
        "board_digest": altered(log, "board_digest", to="0" * 64),
        "world_digest": altered(log, "world_digest", to="0" * 64),
        "drops[0].result.tick": altered(log, "drops", 0, "result", "tick", to=1),
        "drops[0].result.payout": altered(log, "drops", 0, "result", "payout", to=10**17 + 1),
        "drops[0].result": altered(log, "drops", 0, "result", to=None),
        f"drops[{late}].result": altered(
            log, "drops", late, "result", to=log["drops"][0]["result"]
        ),
        "digest": altered(log, "drops", 0, "who", to="bob"),
        "RecordError: colour": altered(log, "colour", to="red"),
        "RecordError: drops[1].ball": altered(log, "drops", 1, "ball", to=5),
        "RecordError: mode": LOGS["scene"](),
    }
    void = {**log["drops"][0]["result"], "bin": None, "score": 1.0, "digest": ""}
    given_up = void | {"payout": log["drops"][late]["stake"]}
    wrong["digest "] = altered(log, "drops", late, "result", to=given_up)  # the rest is valid
    kept = void | {"payout": log["drops"][late]["stake"] + 1}
    wrong[f"drops[{late}].result.payout"] = altered(log, "drops", late, "result", to=kept)
    found = compared(run, log, *wrong.values())
    assert found == [None, *(field.strip() for field in wrong)]


def test_the_log_of_these_tests_has_every_field() -> None:
    log = LOGS["drops"]()
    assert log.keys() == {*DropFormat.needed, *DropFormat.optional}
    assert set().union(*log["drops"]) == {*ENTRY, *ENTRY_OPTIONAL}
    assert {name for drop in log["drops"] for name in drop["result"] or ()} == {*RESULT}


def test_pages_know_the_fields_that_the_server_knows() -> None:
    assert log_fields.FILE.read_text() == log_fields.text(), "python -m tools.log_fields"


def test_a_page_s_largest_stake_is_a_room_s(run: Run) -> None:
    boards = [[0.0], [1.0], [0.3, 1e9], [110.0, 2.5], [1e-7], [123456789.12345679], [5e-324]]
    found = run("model/payout.js", "({ mostStake }, boards) => boards.map(mostStake)", boards)
    assert found == [most_stake(multipliers) for multipliers in boards]


def test_a_page_pays_what_a_room_pays(run: Run) -> None:
    scores = [0.1, 1.3, 1e-7, 1e9, 0.0, 110.0]
    given = [(stake, score) for stake in (0, 1, 7, 10, 100, 999_999_937) for score in scores]
    found = run(
        "model/payout.js",
        "({ exactPayout }, given) => given.map((each) => String(exactPayout(...each)))",
        given,
    )
    assert [int(each) for each in found] == [payout_of(*each) for each in given]
