"""Logs and records that JavaScript has read and written again: 1.0 has become 1, and they hold."""

import json
from typing import Any

import pytest

from app.rooms.log import verify_log
from engine import drop, verify
from tests.app.rooms.logs import LOGS
from tests.app.rooms.test_log import of_first_version
from tests.js.conftest import Run


def rewritten(run: Run, value: Any) -> Any:
    """`value` as JavaScript writes what it has read."""
    return run("util/doubles.js", "(_, value) => value", value)


def test_logs_that_javascript_has_rewritten_hold(run: Run) -> None:
    logs = {kind: make() for kind, make in LOGS.items()}
    logs |= {f"{kind} 1": of_first_version(log) for kind, log in logs.items()}
    again = rewritten(run, logs)
    for kind, log in again.items():
        assert json.dumps(log) != json.dumps(logs[kind]), "no number lost its .0"
        assert verify_log(log).ok, kind


@pytest.mark.parametrize("options", [{"seed": 2**64 - 1}, {"x": 0.0625}])
@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_records_that_javascript_has_rewritten_hold(
    run: Run, options: dict[str, Any], solver: str
) -> None:
    record = drop("triangle-8", solver=solver, **options).record()
    assert verify(rewritten(run, record)).ok
