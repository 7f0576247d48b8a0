"""A room's queue: what waits is dropped once, in order, whatever happens in between."""

from collections import Counter
from pathlib import Path
from typing import Any

import httpx
import pytest

from app.errors import BallLimitError
from app.protocol.visitors import NO_TAG
from app.rooms.queue import EMPTY, MOST_BALLS, MOST_ITEMS, MOST_WAITING
from tests.app.conftest import TINY, Running, playing, serving
from tests.app.live.test_tags import TAG, opened
from tests.waiting import until

QUICK = {**TINY, "gravity": 4000.0}  # its balls land in two ticks


def queue_of(http: httpx.Client, room: str) -> dict[str, Any]:
    found: dict[str, Any] = http.get(f"/api/v1/rooms/{room}/queue").raise_for_status().json()
    return found


def dropped(http: httpx.Client, room: str) -> list[dict[str, Any]]:
    drops: list[dict[str, Any]] = http.get(f"/api/v1/rooms/{room}/log").json()["drops"]
    return drops


async def test_what_waits_is_dropped_in_order_under_its_name_and_told(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http, QUICK)
    path = f"/api/v1/rooms/{room}/queue"
    http.patch(path, json={"paused": True}, headers=own).raise_for_status()
    for item in ({"n": 3, **TAG}, {"n": 5, "name": "Ben"}, {"n": 2}):
        view = http.post(path, json={"every": 0.1, **item}, headers=own)
        assert view.status_code == 202, view.text
    assert (view.json()["waiting"], view.json()["paused"]) == (10, True)
    assert dropped(http, room) == [], "it is paused"
    assert http.post(f"{path}/skip", headers=own).json()["waiting"] == 7
    async with playing(server.socket(room)) as player:
        told = await player.until("queue")
        assert (told["waiting"], told["paused"]) == (7, True)
        assert told["items"] == [{"number": 1, "left": 5, "name": "Ben"}, {"number": 2, "left": 2}]
        http.patch(path, json={"paused": False}, headers=own).raise_for_status()
        assert (await player.until("queue", paused=False))["waiting"] == 7
        await player.until("queue", waiting=0, items=[])
        accepted = [each.get("name") for each in player.events if each["type"] == "accepted"]
    assert accepted == ["Ben"] * 5 + [None] * 2
    assert queue_of(http, room) == {"room": room, "paused": False, "waiting": 0, "items": []}
    http.post(path, json={"n": 9, "every": 60}, headers=own)
    assert http.delete(path, headers=own).json()["waiting"] == 0


@pytest.mark.parametrize(
    ("method", "path"), [("POST", ""), ("PATCH", ""), ("DELETE", ""), ("POST", "/skip")]
)
def test_a_queue_is_its_room_s_owner_s(http: httpx.Client, method: str, path: str) -> None:
    room, _ = opened(http)
    _, other = opened(http)
    for name, shown, status in ((room, {}, 401), (room, other, 403), ("main", other, 403)):
        address = f"/api/v1/rooms/{name}/queue{path}"
        assert http.request(method, address, json={"n": 1}, headers=shown).status_code == status
    assert queue_of(http, "main")["items"] == []


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"n": 0}, "n"),
        ({"n": MOST_BALLS + 1}, "n"),
        ({"n": "3"}, "n"),
        ({"n": 1, "every": 0.0}, "every"),
        ({"n": 1, "name": "<b>"}, "name"),
        ({"n": 1, "colour": "red"}, "colour"),
    ],
)
def test_what_cannot_wait_is_named(http: httpx.Client, body: dict[str, Any], field: str) -> None:
    room, own = opened(http)
    answer = http.post(f"/api/v1/rooms/{room}/queue", json=body, headers=own)
    assert answer.status_code == 422
    assert field in answer.text


def test_no_more_waits_than_may() -> None:
    full = EMPTY
    for _ in range(MOST_ITEMS):
        full = full.with_item(1, 1.0, NO_TAG)
    with pytest.raises(BallLimitError, match=f"{MOST_ITEMS} items wait already"):
        full.with_item(1, 1.0, NO_TAG)
    heavy = EMPTY
    for _ in range(MOST_WAITING // MOST_BALLS):
        heavy = heavy.with_item(MOST_BALLS, 1.0, NO_TAG)
    with pytest.raises(BallLimitError, match=f"n 1: {MOST_WAITING} balls wait already"):
        heavy.with_item(1, 1.0, NO_TAG)
    assert full.skipped().items == full.items[1:]
    assert heavy.cleared().with_item(1, 1.0, NO_TAG).items[0].number == heavy.next


def test_a_room_that_is_begun_anew_forgets_what_waits(http: httpx.Client) -> None:
    room, own = opened(http)
    http.post(f"/api/v1/rooms/{room}/queue", json={"n": 9, "every": 60}, headers=own)
    http.post(f"/api/v1/rooms/{room}/reset", headers=own).raise_for_status()
    assert queue_of(http, room)["items"] == []


def test_two_hundred_balls_are_each_dropped_once_over_a_restart_in_mid_show(
    tmp_path: Path,
) -> None:
    """No client asks for the room in between: the show goes on by itself."""
    kept = {"database_url": f"sqlite:///{tmp_path / 'plinko.db'}"}
    with serving(**kept) as server, httpx.Client(base_url=server.url, timeout=60.0) as http:
        room, own = opened(http, QUICK)
        path = f"/api/v1/rooms/{room}/queue"
        for name in ("Ada", "Ben"):
            item = {"n": 100, "name": name, "every": 0.05}
            http.post(path, json=item, headers=own).raise_for_status()
        live = server.services.rooms.find(room)
        until(lambda: live.room.drops > 5)
    with serving(**kept) as server, httpx.Client(base_url=server.url, timeout=60.0) as http:
        rooms = server.services.rooms
        until(lambda: any(live.room.drops == 200 for live in rooms.all() if live.id == room))
        until(lambda: queue_of(http, room)["waiting"] == 0)
        names = Counter(each.get("name") for each in dropped(http, room))
        order = [each["name"] for each in dropped(http, room)]
    assert names == {"Ada": 100, "Ben": 100}
    assert order == sorted(order)
