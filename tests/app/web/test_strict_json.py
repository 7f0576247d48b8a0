"""Ambiguous JSON is refused in every body, with its place. For messages see live/test_live.py."""

import json
from typing import Any

import httpx
import pytest

from tests.app.conftest import TINY

BIG = 1 << 12  # bytes; a worker checks larger bodies

ENTRANCES: dict[str, dict[str, Any]] = {
    "boards": TINY,
    "boards/check": TINY,
    "drops": {"board": "triangle-8", "seed": "1"},
    "simulate": {"board": "triangle-8", "drops": 2, "seed": "1"},
    "payouts": {"board": "triangle-8"},
    "verify": {"kind": "none"},
    "rooms": {"board": "triangle-8"},
    "rooms/main/drops": {"seed": "1"},
    "sessions": {"room": "main", "commitment": "00" * 32},
}


def refused(http: httpx.Client, path: str, body: str, padding: int = 0) -> dict[str, Any]:
    """Send a body, lengthened by `padding` blanks; returns the problem details of the 422."""
    response = http.post(f"/api/v1/{path}", content=(body + " " * padding).encode())
    assert response.status_code == 422, response.text
    found: dict[str, Any] = response.json()
    return found


@pytest.mark.parametrize("padding", [0, BIG], ids=["short", "long"])
@pytest.mark.parametrize("path", ENTRANCES)
def test_a_key_given_twice_is_refused_in_every_body(
    http: httpx.Client, path: str, padding: int
) -> None:
    form = ENTRANCES[path]
    name, value = next(iter(form.items()))
    again = f"{json.dumps(form)[:-1]}, {json.dumps(name)}: {json.dumps(value)}}}"
    problem = refused(http, path, again, padding)
    assert (problem["field"], problem["detail"]) == (name, f"{name}: the key is given twice")


@pytest.mark.parametrize("padding", [0, BIG], ids=["short", "long"])
@pytest.mark.parametrize("path", ["boards", "boards/check", "drops", "simulate", "rooms"])
@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("NaN", "NaN is not a JSON number"),
        ("1e999", "1e999 is out of range"),
        (r'"\ud800"', r"'\ud800' has a lone surrogate, which is not a character"),
        ('0.05, "radius": 0.01', "the key is given twice"),
    ],
    ids=["nan", "huge", "surrogate", "twice"],
)
def test_a_board_s_value_that_is_none_is_named_by_its_place(
    http: httpx.Client, path: str, value: str, why: str, padding: int
) -> None:
    board = json.dumps(TINY).replace('"radius": 0.05', f'"radius": {value}')
    place = "pegs[0].radius"
    if not path.startswith("boards"):
        board, place = f'{{"board": {board}}}', f"board.{place}"
    problem = refused(http, path, board, padding)
    assert problem["field"] == place
    assert why in problem["detail"]


def test_a_body_nested_too_deeply_is_malformed(http: httpx.Client) -> None:
    for padding in (0, BIG):
        body = b'{"board": ' + b"[" * 900 + b"]" * 900 + b"}" + b" " * padding
        response = http.post("/api/v1/rooms", content=body)
        assert (response.status_code, response.json()["code"]) == (400, "malformed")
