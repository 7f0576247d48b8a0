"""Proofs over HTTP: their content, refused requests, and their price."""

import json
import logging

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.computing import tasks
from plinko.app.computing.tasks import Ask
from plinko.app.web.routes.drops import drops
from plinko.app.web.schemas.drops import Proven
from plinko.engine import Board, certify
from plinko.engine.parameters import Exact

DROP = "/api/v1/drops/triangle-8/42"


def test_a_drop_is_proven_when_asked(http: httpx.Client) -> None:
    plain = http.get(DROP).json()
    asked = http.get(f"{DROP}?certified=true").json()
    certificate = asked.pop("certificate")
    assert asked == plain
    expected = certify(Board.preset("triangle-8"), 42)
    rows = [list(row) for row in expected.event_rows()]
    assert certificate == expected.to_dict() | {"events": rows}
    assert set(certificate) == set(Proven.__struct_fields__)
    assert certificate["certified"]
    assert certificate["x_end"]["low"] <= plain["x_end"] + 1e-6
    wanted = {"board": "triangle-8", "seed": "42", "certified": True}
    assert http.post("/api/v1/drops", json=wanted).json()["certificate"] == certificate


def test_the_command_line_and_the_server_go_equally_far(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from plinko.engine.certified.certify import Effort

    few = Effort(most_bits=160, most_comparisons=30)
    monkeypatch.setattr(tasks, "proof_effort", lambda: few)
    with pytest.raises(SystemExit, match="1"):
        main(["certify", "triangle-8", "--seed", "42", "--json"])
    told = json.loads(capsys.readouterr().out)["undecided"]
    ask = Ask(Board.preset("triangle-8"), 42, None, Exact())
    assert told == json.loads(tasks.proof(ask, False)[1])["certificate"]["undecided"]
    assert told == "more than 30 comparisons: undecided at 160 bits"


def test_a_missing_part_is_no_error_in_the_log(
    http: httpx.Client,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(drops, "_is_installed", lambda: False)
    with caplog.at_level(logging.INFO):
        answer = http.get("/api/v1/drops/triangle-8/1?certified=1")
    assert (answer.status_code, answer.json()["code"]) == (501, "not-installed")
    assert [each.getMessage() for each in caplog.records if each.levelno >= logging.WARNING] == []
