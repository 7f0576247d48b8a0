"""Standards of HTTP: HEAD, compressed and conditional replies, pages, queries."""

import json
import re
from typing import Any

import httpx
import pytest

from plinko.app.computing import tasks
from plinko.app.errors import InvalidValueError
from plinko.app.rooms.log import verify_log
from plinko.engine import Board
from tests.app.conftest import QUICK

DROP = "/api/v1/drops/triangle-8/42"


def opened(http: httpx.Client, **body: Any) -> tuple[str, dict[str, str]]:
    """Create a room; returns its path and the headers with its token."""
    room = http.post("/api/v1/rooms", json=body or {"board": QUICK}).json()
    return f"/api/v1/rooms/{room['id']}", {"authorization": f"Bearer {room['token']}"}


def land(http: httpx.Client, room: str, *seeds: int) -> None:
    for seed in seeds:
        reply = http.post(f"{room}/drops?wait=1", json={"seed": seed})
        assert reply.status_code == 200, reply.text


# HEAD.


def test_head_says_what_get_would_and_sends_no_body(http: httpx.Client) -> None:
    room, _ = opened(http)  # nothing moves in it between the two requests
    for path in (
        "/", "/js/play/main.js", "/healthz", "/readyz", "/metrics", "/openapi.json",
        "/api/v1/boards", "/api/v1/boards/classic", "/api/v1/rooms", "/api/v1/rooms/main",
        f"{room}/log", "/api/v1/scenes", DROP, f"{DROP}.png", f"{DROP}/frames", f"{room}/frame.png",
    ):  # fmt: skip
        head = http.head(path)
        assert (head.status_code, head.content) == (200, b""), path
        got = http.get(path)
        for name in ("content-type", "etag", "cache-control", "vary", "content-encoding"):
            assert head.headers.get(name) == got.headers.get(name), (path, name)
    for path in ("/api/v1/rooms/nope", "/api/v1/nothing", "/nothing.js"):
        assert http.head(path).status_code == 404
    refused = http.head("/api/v1/drops")
    assert (refused.status_code, refused.headers["allow"]) == (405, "POST")


# Queries.


def test_the_stepped_solver_has_its_own_parameters(http: httpx.Client) -> None:
    plain = http.get(f"{DROP}?solver=stepped").json()
    asked = http.get(f"{DROP}?solver=stepped&dt={1 / 60}&substeps=4").json()
    assert plain == asked
    finer = http.get(f"{DROP}?solver=stepped&dt=0.01").json()
    assert (finer["dt"], finer["substeps"]) == (0.01, 4)


def test_instance_is_an_address_whatever_was_asked_for(http: httpx.Client) -> None:
    refused = http.get("/api/v1/boards/%C3%BC%20%22%3C").json()
    assert refused["instance"] == "/api/v1/boards/%C3%BC%20%22%3C"
    missing = http.get("/no%20such").json()
    assert missing["instance"] == "/no%20such"


# Compressed and conditional replies.


def test_a_page_s_parts_are_cached_for_good_the_page_is_not(http: httpx.Client) -> None:
    page = http.get("/")
    assert page.headers["cache-control"] == "no-cache"
    assert http.get("/", headers={"if-none-match": page.headers["etag"]}).status_code == 304
    parts = re.findall('(?:href|src)="(v-[0-9a-f]{16}/[^"]+)"', page.text)
    assert {part.rsplit(".", 1)[1] for part in parts} == {"css", "js"}
    for part in parts:
        kept = http.get(f"/{part}")
        assert kept.headers["cache-control"] == "public, max-age=31536000, immutable"
        now = http.get("/" + part.partition("/")[2])
        assert (now.content, now.headers["cache-control"]) == (kept.content, "no-cache")
    other = http.get("/v-0123456789abcdef/js/play/main.js")
    assert other.headers["cache-control"] == "no-cache", "of another release, as it is now"


def test_a_boards_etag_is_its_digest(http: httpx.Client) -> None:
    digest = Board.preset("classic").digest
    for path in ("/api/v1/boards/classic", f"/api/v1/boards/{digest}"):
        plain = http.get(path, headers={"accept-encoding": "identity"})
        assert plain.headers["etag"] == f'"{digest}"'
        again = http.get(path, headers={"if-none-match": f'"{digest}"'})
        assert (again.status_code, again.content) == (304, b"")


# Pages.


def test_rooms_come_in_pages_that_miss_none(http: httpx.Client) -> None:
    mine = {opened(http)[0].rpartition("/")[2] for _ in range(5)}
    found: list[str] = []
    after = ""
    while True:
        query: dict[str, str | int] = {"limit": 2, **({"after": after} if after else {})}
        page = http.get("/api/v1/rooms", params=query).json()
        assert len(page["rooms"]) <= 2
        found += [room["id"] for room in page["rooms"]]
        if page["next"] is None:
            break
        after = page["next"]
    assert mine <= set(found)
    assert len(found) == len(set(found))
    assert "main" in found
    assert found == [room["id"] for room in http.get("/api/v1/rooms").json()["rooms"]]
    # One room is found whatever page it would be on.
    for room in (*mine, "main"):
        page = http.get("/api/v1/rooms", params={"id": room, "limit": 1}).json()
        assert [each["id"] for each in page["rooms"]] == [room]
        assert page["next"] is None
    assert http.get("/api/v1/rooms?id=gone").json() == {"rooms": [], "next": None}


def test_rooms_of_one_mode_come_in_pages_of_their_own(http: httpx.Client) -> None:
    for body in ({"board": QUICK}, {"board": QUICK, "mode": "interacting"}, {"scene": "sandbox"}):
        opened(http, **body)
    every = http.get("/api/v1/rooms").json()["rooms"]
    for mode in ("independent", "interacting", "scene"):
        first = http.get("/api/v1/rooms", params={"mode": mode, "limit": 1}).json()["rooms"]
        rest = {"mode": mode, "after": first[0]["id"]}
        found = [*first, *http.get("/api/v1/rooms", params=rest).json()["rooms"]]
        assert [each["id"] for each in found] == [
            each["id"] for each in every if each["mode"] == mode
        ]


def test_one_board_is_found_by_its_digest(http: httpx.Client) -> None:
    own = http.post("/api/v1/boards", json={**QUICK, "name": "one of many"}).json()["digest"]
    preset = Board.preset("triangle-12")
    expected = ((own, "one of many", False), (preset.digest, preset.name, True))
    for digest, name, is_preset in expected:
        (found,) = http.get("/api/v1/boards", params={"digest": digest}).json()["boards"]
        assert (found["digest"], found["name"], found["preset"]) == (digest, name, is_preset)
    form = {**QUICK, "name": "only a room's"}
    room = http.post("/api/v1/rooms", json={"board": form}).json()
    assert http.get(f"/api/v1/boards/{room['board_digest']}").json()["name"] == "only a room's"
    for unknown in ("0" * 64, "triangle-12"):
        assert http.get("/api/v1/boards", params={"digest": unknown}).json() == {"boards": []}


def test_a_log_has_another_etag_when_something_happened_and_comes_in_parts(
    http: httpx.Client,
) -> None:
    room, _ = opened(http)
    first_tag = {"if-none-match": http.get(f"{room}/log").headers["etag"]}
    assert http.get(f"{room}/log", headers=first_tag).status_code == 304
    land(http, room, 1, 2, 3, 4, 5)
    after = http.get(f"{room}/log", headers=first_tag)
    assert after.status_code == 200
    assert after.headers["etag"] != first_tag["if-none-match"]
    whole = after.json()
    parts = []
    first: int | None = 0
    while first is not None:
        part = http.get(f"{room}/log", params={"first": first, "limit": 2}).json()
        assert (part["first"], part["digest"]) == (first, None)
        assert part["world_digest"] == whole["world_digest"]
        parts += part["drops"]
        first = part["next"]
    assert parts == whole["drops"]
    assert "next" not in whole
    beyond = http.get(f"{room}/log?first=9").json()
    assert (beyond["drops"], beyond["next"]) == ([], None)


# Logs of closed rooms, and their verification.


def test_a_closed_rooms_log_stays_readable_and_verifies(http: httpx.Client) -> None:
    room, token = opened(http)
    land(http, room, 1, 2)
    http.post(f"{room}/drops", json={"seed": 3, "who": "ann"})
    assert http.delete(room, headers=token).status_code == 204
    assert http.get(room).status_code == 404
    log = http.get(f"{room}/log").json()
    assert [each["seed"] for each in log["drops"]] == ["1", "2", "3"]
    assert all(each["result"] for each in log["drops"]), "what fell has landed"
    assert [each["who"] for each in log["drops"]] == [None] * 3
    assert verify_log(log).ok
    shown = http.get(f"{room}/log", headers=token).json()
    assert shown["drops"][2]["who"] == "ann"


@pytest.mark.parametrize("kind", [{"board": QUICK}, {"scene": {"scene": "sandbox", "balls": 3}}])
def test_verify_takes_a_rooms_log(http: httpx.Client, kind: dict[str, Any]) -> None:
    room, token = opened(http, **kind)
    if "board" in kind:
        land(http, room, 7)
    log = http.get(f"{room}/log", headers=token).json()
    good = http.post("/api/v1/verify", json=log)
    assert (good.status_code, good.json()["ok"]) == (200, True)
    log["world_digest"] = "0" * 64
    bad = http.post("/api/v1/verify", json=log).json()
    assert (bad["ok"], bad["field"], bad["expected"]) == (False, "world_digest", "0" * 64)


def test_a_log_that_would_be_replayed_for_ever_is_given_up(
    http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tasks, "MAX_SECONDS", 0.05)
    room, _ = opened(http, board="triangle-8", mode="interacting")
    log = {**http.get(f"{room}/log").json(), "tick": 10**15}
    with pytest.raises(InvalidValueError, match="use plinko verify, which has no limit") as caught:
        tasks.log_verdict(log)
    assert caught.value.field == "tick"
    # A year between two drops of a table costs a check nothing.
    room, _ = opened(http)
    land(http, room, 1)
    log = {**http.get(f"{room}/log").json(), "tick": 60 * 60 * 24 * 366 * 60}
    assert json.loads(tasks.log_verdict(log))["field"] == "world_digest"
