"""Drops over REST: the reply is the same whether the server or a worker computes it."""

from typing import Any

import httpx
import pytest

from plinko.engine import Board
from tests.kit.serving import Running

DROP = "/api/v1/drops/triangle-12/42"
OWN = Board.preset("triangle-8").replace(name="own").to_dict()


class Counted:
    """Counts the calls of a method, and passes them on."""

    def __init__(self, patch: pytest.MonkeyPatch, owner: object, name: str) -> None:
        self.calls = 0
        self._method = getattr(owner, name)
        patch.setattr(owner, name, self)

    def __call__(self, *args: Any, **given: Any) -> Any:
        self.calls += 1
        return self._method(*args, **given)


@pytest.fixture
def here(http: httpx.Client, server: Running, monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Counts the drops computed by the server itself, for which DROP's preset is ready."""
    counted = Counted(monkeypatch, server.services.computing, "at_once")
    while not counted.calls:
        assert http.get(DROP).status_code == 200
    counted.calls = 0
    return counted


@pytest.fixture
def by_workers(server: Running, monkeypatch: pytest.MonkeyPatch) -> Counted:
    """Counts the computations in workers."""
    return Counted(monkeypatch, server.services.computing.workers, "measured")


def test_a_presets_drop_takes_no_worker_and_any_other_one_does(
    http: httpx.Client, here: Counted, by_workers: Counted
) -> None:
    digest = http.post("/api/v1/boards", json=OWN).json()["digest"]
    by_workers.calls = 0
    assert http.get(DROP).status_code == 200
    assert http.post("/api/v1/drops", json={"board": "triangle-12"}).status_code == 200
    assert (here.calls, by_workers.calls) == (2, 0)
    for path in (f"/api/v1/drops/{digest}/42", f"{DROP}?solver=stepped", f"{DROP}?certainty=true"):
        assert http.get(path).status_code == 200
    assert (here.calls, by_workers.calls) == (2, 3)


def test_a_drop_that_exceeds_its_price_goes_to_a_worker(
    limited_calls: None,
    http: httpx.Client,
    server: Running,
    here: Counted,
    by_workers: Counted,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    expected = http.get(DROP)
    assert (here.calls, by_workers.calls) == (1, 0)
    monkeypatch.setattr(server.services.computing, "effort", 1000)
    found = http.get(DROP)
    assert (here.calls, by_workers.calls) == (2, 1)
    assert (found.status_code, found.content) == (200, expected.content)
    assert found.headers["etag"] == expected.headers["etag"]


@pytest.mark.parametrize(
    ("path", "options"),
    [
        (DROP, "solver=exact&certainty=false"),
        (f"{DROP}x", "solver=exact&certainty=false"),
        ("/api/v1/drops/nowhere/42", "solver=exact&certainty=false"),
        (f"{DROP}/frames", "fps=60"),
    ],
)
def test_an_address_alone_says_what_all_of_its_options_say(
    http: httpx.Client, path: str, options: str
) -> None:
    alone, spelt = http.get(path), http.get(f"{path}?{options}")
    assert (alone.status_code, alone.content) == (spelt.status_code, spelt.content)
    assert alone.headers.get("etag") == spelt.headers.get("etag")
    if alone.is_success:
        current = {"if-none-match": alone.headers["etag"]}
        assert http.get(path, headers=current).status_code == 304
