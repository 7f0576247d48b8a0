"""Proofs over HTTP: what they say, what may not be asked, and what they may cost."""

import httpx
import pytest

from app.web.routes import certificates
from app.web.schemas.drops import Proven
from engine import Board, certify
from tests.app.web.test_rest import problem

DROP = "/api/v1/drops/triangle-8/42"


def test_a_drop_is_proven_when_asked(http: httpx.Client) -> None:
    plain = http.get(DROP).json()
    asked = http.get(f"{DROP}?certified=true").json()
    certificate = asked.pop("certificate")
    assert asked == plain
    expected = certify(Board.preset("triangle-8"), 42)
    rows = [list(row) for row in expected.event_rows()]
    assert certificate == expected.to_json() | {"events": rows}
    assert set(certificate) == set(Proven.__struct_fields__)
    assert certificate["certified"]
    assert certificate["x_end"]["low"] <= plain["x_end"] + 1e-6
    wanted = {"board": "triangle-8", "seed": "42", "certified": True}
    assert http.post("/api/v1/drops", json=wanted).json()["certificate"] == certificate


def test_only_the_exact_solver_is_proven(http: httpx.Client) -> None:
    response = http.get(f"{DROP}?solver=stepped&certified=true")
    problem(response, 422, "invalid-value", "'stepped'")


def test_a_server_without_the_library_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(certificates, "_is_installed", lambda: False)
    with pytest.raises(certificates.MissingPartError, match="pip install"):
        certificates.require_certifier()


def test_a_proof_that_costs_too_much_is_given_up() -> None:
    from engine.certified.certify import Effort

    effort = Effort(first_bits=64, most_bits=128, most_comparisons=20)
    found = certify(Board.preset("triangle-8"), 42, effort=effort)
    assert not found.decided
    assert found.bin is None
    assert found.undecided == "more than 20 comparisons"
    assert (found.bits, found.agrees, found.x_end) == (128, None, None)
