"""A room's show: only its owner sets it, stages learn that it changed, and it outlives restarts."""

from pathlib import Path
from typing import Any

import httpx

from plinko.app.web.routes.rooms.shows import MAX_SHOW
from tests.app.live.test_tags import opened
from tests.kit.player import playing
from tests.kit.serving import Running, serving

PIXEL = "data:image/png;base64,iVBORw0KGgo="
SHOW: dict[str, Any] = {
    "timer": {"left": 60.0, "label": "Ends in", "running": False},
    "goals": [{"value": 3.0, "target": 10.0, "label": "Balls"}],
    "jackpot": {"value": 12.5, "label": "Jackpot", "unit": "x"},
    "looks": {"panel": "#102030", "ink": "#ffffff", "accent": "#e91e63",
              "font": "Comic Neue", "logo": PIXEL},
    "faces": {"Ada": "\U0001f9c0", "Ben": PIXEL},
}  # fmt: skip


def shown(http: httpx.Client, room: str) -> dict[str, Any]:
    view: dict[str, Any] = http.get(f"/api/v1/rooms/{room}/show").raise_for_status().json()
    return view


async def test_stages_learn_of_a_new_show(server: Running, http: httpx.Client) -> None:
    room, own = opened(http)
    assert shown(http, room) == {"room": room, "age": 0.0, "show": {}}
    async with playing(server.socket(room)) as stage:
        http.put(f"/api/v1/rooms/{room}/show", json=SHOW, headers=own).raise_for_status()
        assert await stage.until("show") == {"type": "show"}
    view = shown(http, room)
    assert (view["show"], view["age"] >= 0.0) == (SHOW, True)
    http.put(f"/api/v1/rooms/{room}/show", json={}, headers=own).raise_for_status()
    assert shown(http, room)["show"] == {}, "a show is replaced as a whole"


def test_a_show_outlives_a_reset_and_a_restart(tmp_path: Path) -> None:
    settings = {"data": str(tmp_path), "database_url": f"sqlite:///{tmp_path / 'plinko.db'}"}
    with serving(**settings) as server, server.client() as http:
        room, own = opened(http)
        http.put(f"/api/v1/rooms/{room}/show", json=SHOW, headers=own).raise_for_status()
        http.post(f"/api/v1/rooms/{room}/reset", headers=own).raise_for_status()
        assert shown(http, room)["show"] == SHOW
    with serving(**settings) as server, server.client() as http:
        assert shown(http, room)["show"] == SHOW


def test_a_show_is_its_room_s_owner_s(http: httpx.Client) -> None:
    room, _ = opened(http)
    _, other = opened(http)
    for name, token, status in ((room, {}, 401), (room, other, 403), ("main", other, 403)):
        reply = http.put(f"/api/v1/rooms/{name}/show", json=SHOW, headers=token)
        assert reply.status_code == status


WRONG: dict[str, dict[str, Any]] = {
    "timer.left": {"timer": {"left": -1}},
    "goals[0].target": {"goals": [{"value": 1, "target": 0}]},
    "goals": {"goals": [{"value": 1, "target": 1}] * 5},
    "looks.ink": {"looks": {"ink": "red"}},
    "looks.font": {"looks": {"font": "x; } body { display: none"}},
    "looks.logo": {"looks": {"logo": "https://example.org/logo.png"}},
    "faces[...]": {"faces": {"Ada": "https://example.org/ada.png"}},
    "script": {"script": "alert(1)"},
}


def test_a_show_with_a_bad_value_is_refused(http: httpx.Client) -> None:
    room, own = opened(http)
    page = {"looks": {"logo": "data:text/html;base64,AAAA"}}
    for field, wrong in (*WRONG.items(), ("looks.logo", page)):
        reply = http.put(f"/api/v1/rooms/{room}/show", json=wrong, headers=own)
        assert (reply.status_code, reply.json()["field"]) == (422, field)
        assert shown(http, room)["show"] == {}
    # A show has a size that fits a stream.
    large = {"looks": {"logo": "data:image/png;base64," + "A" * MAX_SHOW}}
    reply = http.put(f"/api/v1/rooms/{room}/show", json=large, headers=own)
    assert reply.status_code == 413
