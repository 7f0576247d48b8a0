"""Rooms with a draw over REST and WebSocket: what is published, accepted and refused."""

import hashlib
from typing import Any

import httpx
import pytest

from plinko.app.rooms.canonical import canonical
from plinko.app.rooms.log import verify_log
from plinko.engine import Board, drop, find_draw
from tests.app.conftest import QUICK
from tests.app.live.sessions.test_fair_sessions import (
    COMMITMENT,
    SEED,
    bearer,
    begun,
    checked,
    exported,
)
from tests.kit.player import playing
from tests.kit.serving import Running

BOARD = Board.from_json(QUICK)
ODDS = [9999, 1]
DRAW = find_draw(BOARD, ODDS, per_bin=5)


def opening(**changes: Any) -> dict[str, Any]:
    return {"board": QUICK, "mode": "draw", "draw": DRAW, **changes}


@pytest.fixture(scope="module")
def opened(http: httpx.Client) -> dict[str, Any]:
    answer = http.post("/api/v1/rooms", json=opening())
    assert answer.status_code == 201, answer.text
    view: dict[str, Any] = answer.json()
    return view


def refused(answer: httpx.Response, field: str, words: str) -> None:
    assert (answer.status_code, answer.json()["field"]) == (422, field), answer.text
    assert words in answer.json()["detail"]


def test_odds_are_published_with_one_digest_of_all_they_rest_on(
    http: httpx.Client, opened: dict[str, Any]
) -> None:
    place = f"/api/v1/rooms/{opened['id']}"
    view, whole = http.get(place).json(), http.get(f"{place}/draw")
    assert (view["mode"], view["board_digest"]) == ("draw", BOARD.digest)
    assert view["draw"] == {"digest": opened["draw"]["digest"], "weights": ODDS}
    assert hashlib.sha256(canonical(whole.json())).hexdigest() == view["draw"]["digest"]
    assert whole.json() == {
        "kind": "plinko draw", "version": 1, "board_digest": BOARD.digest, **DRAW,
    }  # fmt: skip
    again = http.get(f"{place}/draw", headers={"if-none-match": whole.headers["etag"]})
    assert again.status_code == 304
    assert http.get("/api/v1/rooms/main").json()["draw"] is None
    listed = http.get("/api/v1/rooms", params={"mode": "draw"}).json()["rooms"]
    assert opened["id"] in {each["id"] for each in listed}


def test_a_session_there_is_proven_with_its_draw(
    http: httpx.Client, opened: dict[str, Any]
) -> None:
    session, shown = begun(http, opened["id"])
    assert session["statement"]["draw_digest"] == opened["draw"]["digest"]
    drops, body = f"/api/v1/rooms/{opened['id']}/drops", {"session": session["session"]}
    for _ in range(2):
        reply = http.post(drops, params={"wait": 1}, json=body, headers=shown)
        each = reply.json()["landed"]
        assert each["seed"] in DRAW["seeds"][each["bin"]]
        assert each["digest"] == drop(BOARD, each["seed"]).digest, "nothing steers the ball"
    http.post(f"/api/v1/sessions/{session['session']}/end", headers=shown)
    verdict = checked(http, session["session"], shown)
    assert verdict.failed == []
    assert {"draw", "drawn-bin"} <= {step.name for step in verdict.steps}
    other = exported(http, session["session"], shown)["draw"] | {"weights": [1, 1]}
    forged = checked(http, session["session"], shown, draw=other)
    assert "draw" in {step.name for step in forged.failed}
    log = http.get(f"/api/v1/rooms/{opened['id']}/log").json()
    assert verify_log(log).ok


def test_neither_what_the_draw_does_not_decide_nor_a_queue_nor_another_board_is_for_it(
    http: httpx.Client, opened: dict[str, Any]
) -> None:
    place, own = f"/api/v1/rooms/{opened['id']}", bearer(opened["token"])
    for free in ({}, {"seed": "1"}, {"x": 0.1}):
        refused(http.post(f"{place}/drops", json=free), "session", "in a fair session only")
    session, shown = begun(http, opened["id"])
    for chosen, field, words in (
        ({"aim": 0.1}, "aim", "leave aim out"),
        ({"seed": DRAW["seeds"][1][0]}, "session", "neither seed nor x"),
        ({"x": 0.1}, "session", "neither seed nor x"),
    ):
        body = {**chosen, "session": session["session"]}
        refused(http.post(f"{place}/drops", json=body, headers=shown), field, words)
    answer = http.post(f"{place}/queue", json={"n": 1, "name": "Ada"}, headers=own)
    refused(answer, "session", "in a fair session only")
    answer = http.patch(place, json={"board": "triangle-8"}, headers=own)
    refused(answer, "board", "seeds fit only its board")
    again = http.post(f"{place}/reset", headers=own).json()
    assert again["draw"] == opened["draw"]


async def test_over_the_socket_the_odds_come_with_the_hello(
    server: Running, opened: dict[str, Any]
) -> None:
    async with playing(server.socket(opened["id"])) as player:
        assert player.hello["draw"] == opened["draw"]
        await player.send(type="drop", ref=1)
        error = await player.until("error", ref=1)
        assert "in a fair session only" in error["detail"]
    async with playing(server.socket("main")) as player:
        assert "draw" not in player.hello


LEFT, RIGHT = DRAW["seeds"]


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        ({"draw": None}, "draw", "draw` together"),
        ({"mode": "independent"}, "draw", "draw` together"),
        ({"mode": "interacting"}, "draw", "draw` together"),
        ({"board": None, "scene": "sandbox"}, "scene", "not a scene"),
        ({"draw": DRAW | {"weights": [1]}}, "draw.weights", "a list of 2"),
        (
            {"draw": DRAW | {"seeds": [LEFT, [RIGHT[0], LEFT[0]]]}},
            "draw.seeds[1][1]",
            f"draw.seeds[1][1]: the ball of seed {LEFT[0]} lands in bin 0",
        ),
        ({"draw": DRAW | {"seeds": "all"}}, "draw.seeds", "2 lists"),
        ({"draw": DRAW | {"seeds": [["1"] * 10_001, RIGHT]}}, "draw.seeds", "at most 10000"),
    ],
)
def test_an_invalid_draw_opens_no_room(
    http: httpx.Client, changes: dict[str, Any], field: str, words: str
) -> None:
    refused(http.post("/api/v1/rooms", json=opening(**changes)), field, words)


def test_the_owner_of_a_room_names_the_drops_of_a_session(
    http: httpx.Client, opened: dict[str, Any]
) -> None:
    """A request has one token: a session's, if the session was begun with the room's token."""
    room, own = opened["id"], bearer(opened["token"])
    body = {"room": room, "commitment": COMMITMENT}
    session = http.post("/api/v1/sessions", json=body, headers=own).json()
    shown, place = bearer(session["token"]), f"/api/v1/sessions/{session['session']}"
    assert http.post(f"{place}/opening", json={"seed": SEED.hex()}, headers=shown).json()["open"]
    tagged = {"session": session["session"], "name": "Ada", "colour": "#e91e63"}
    drops = f"/api/v1/rooms/{room}/drops"
    answer = http.post(drops, params={"wait": 1}, json=tagged, headers=shown).json()
    assert (answer["name"], answer["landed"]["colour"]) == ("Ada", "#e91e63")
    assert answer["receipt"]["receipt"]["session"] == session["session"]
    http.post(f"{place}/end", headers=shown)
    assert checked(http, session["session"], shown).failed == []

    # Other clients may not, also with a session of theirs.
    theirs, their_token = begun(http, room)
    answer = http.post(drops, json=tagged | {"session": theirs["session"]}, headers=their_token)
    assert (answer.status_code, answer.json()["code"]) == (403, "not-yours")
    answer = http.post(drops, json=tagged | {"session": theirs["session"]}, headers=shown)
    assert answer.status_code == 403
    answer = http.post("/api/v1/sessions", json=body, headers=their_token)
    assert answer.status_code == 403
    another = http.post("/api/v1/rooms", json={"board": QUICK}).json()
    answer = http.post("/api/v1/sessions", json=body, headers=bearer(another["token"]))
    assert answer.status_code == 403
