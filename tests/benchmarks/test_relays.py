"""The cost of a spectator over a relay is the difference between two crowds."""

import json
import resource
from dataclasses import replace

import pytest

from benchmarks.harness.effort import MissingError
from benchmarks.harness.report import Section
from benchmarks.serving import relays
from benchmarks.serving.relays import Shares

FEW = Shares(
    1000,
    server=0.1,
    redis=0.01,
    relays=0.05,
    messages=10.0,
    bytes=1e3,
    least=9,
    most=11,
    memory=1e8,
)
MANY = replace(FEW, spectators=5000, relays=0.25, memory=1.8e8)


def test_a_spectators_cost_is_the_difference_of_crowds() -> None:
    table = relays._each(FEW, MANY)
    assert [row[1:] for row in table.rows] == [
        ["0.00500%", "measured"],
        ["20,000", "measured"],
        ["20,000", "measured"],
        ["50.0", "extrapolated"],
        ["1.00 GB", "extrapolated"],
    ]
    section = Section("relays", [relays._shares([FEW, MANY]), table])
    section.data["relays"] = [relays.vars_of(each) for each in (FEW, MANY)]
    assert json.loads(json.dumps(section.to_dict()))["data"]["relays"][1]["spectators"] == 5000
    assert "| 5,000" in section.text()


def test_a_system_with_too_few_files_is_reported_before_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    raised: list[tuple[int, int]] = []
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: raised.append(limits))
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1024, 4096))
    with pytest.raises(MissingError, match=r"5,000 spectators need 5,200 .* 4,096"):
        relays.check_files(5000)
    assert raised == []
    relays.check_files(3000)
    assert raised == [(3200, 4096)]


@pytest.mark.parametrize("starved", [replace(MANY, relays=0.04), replace(MANY, messages=5.0)])
def test_a_machine_that_is_too_busy_is_named(starved: Shares) -> None:
    with pytest.raises(MissingError, match="too busy"):
        relays._each(FEW, starved)
