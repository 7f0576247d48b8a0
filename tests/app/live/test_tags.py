"""Names and colours of drops are sent and stored, but change no result and no proof."""

import csv
import io
from pathlib import Path
from typing import Any

import httpx

from plinko.app.rooms.log import verify_log
from plinko.engine import Board, drop
from tests.app.conftest import QUICK, TINY
from tests.kit.player import Player, playing
from tests.kit.serving import Running, serving

# A right-to-left name with an emoji.
TAG = {"name": "\u05e9\u05e8\u05d4 \U0001f388", "colour": "#e91e63"}
NO_TAG: dict[str, str] = {}


def tag_of(told: dict[str, Any]) -> dict[str, Any]:
    return {field: told[field] for field in TAG if field in told}


async def both(player: Player, kind: str) -> list[dict[str, Any]]:
    """The first two events of this type, sorted by ball."""
    while player.kinds().count(kind) < 2:
        await player.step()
    return sorted((e for e in player.events if e["type"] == kind), key=lambda e: str(e["ball"]))


def opened(http: httpx.Client, board: Any = TINY, **more: Any) -> tuple[str, dict[str, str]]:
    reply = http.post("/api/v1/rooms", json={"board": board, **more}).raise_for_status().json()
    return reply["id"], {"authorization": f"Bearer {reply['token']}"}


async def test_a_tag_is_sent_with_its_drop_and_adds_no_other_field(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http, QUICK)
    path = f"/api/v1/rooms/{room}/drops"
    mark = {"who": f"mark of {room}"}
    async with (
        playing(server.socket(room)) as full,
        playing(server.socket(room) + "?stream=seeds") as brief,
    ):
        reply = http.post(path, json={"seed": 1, **TAG, **mark}, headers=own).json()
        plain = http.post(path, json={"seed": 2, **mark}).json()
        accepted, landed = [await both(full, kind) for kind in ("accepted", "landed")]
        briefly = await both(brief, "accepted")
    for told in ((reply, plain), accepted, landed, briefly):
        assert [tag_of(each) for each in told] == [TAG, NO_TAG]
    assert landed[0]["digest"] == drop(Board.from_json(QUICK), 1).digest
    log = http.get(f"/api/v1/rooms/{room}/log").json()
    assert [tag_of(each) for each in log["drops"]] == [TAG, NO_TAG]
    bare = {**log, "drops": [{k: v for k, v in d.items() if k not in TAG} for d in log["drops"]]}
    assert verify_log(log).ok
    assert verify_log(bare).ok, "the log's digest does not cover it"
    plays = http.get(f"/api/v1/players/{mark['who']}/plays", params={"format": "csv"})
    rows = list(csv.DictReader(io.StringIO(plays.content.decode("utf-8-sig"))))
    assert [tag_of(row) for row in rows] == [dict.fromkeys(TAG, ""), TAG]


async def test_who_comes_late_sees_the_tags_of_what_flies(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http, {**TINY, "gravity": 0.01})
    for tag in (TAG, {}):
        http.post(f"/api/v1/rooms/{room}/drops", json=tag, headers=own).raise_for_status()
    async with playing(server.socket(room)) as late:
        assert [tag_of(each) for each in late.hello["balls"]] == [TAG, NO_TAG]


async def test_only_owners_give_tags_and_in_open_rooms_everybody(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http)
    path = f"/api/v1/rooms/{room}/drops"
    _, other = opened(http)
    for shown, status in ((NO_TAG, 401), (other, 403), (own, 202)):
        assert http.post(path, json=TAG, headers=shown).status_code == status
    assert http.post(path, json={"colour": TAG["colour"]}).status_code == 401
    assert http.post(path).status_code == 202, "without a tag it is as ever"
    async with playing(server.socket(room)) as player:
        await player.send(type="drop", ref=1, **TAG)
        assert (await player.until("error", ref=1))["code"] == "not-yours"
        await player.send(type="claim", token=own["authorization"].split()[1])
        await player.until("claimed")
        await player.send(type="drop", ref=2, **TAG)
        assert tag_of(await player.until("accepted", ref=2)) == TAG
    async with playing(server.socket("triangle-8")) as player:
        await player.send(type="drop", ref=3, name="Ada")
        assert tag_of(await player.until("accepted", ref=3)) == {"name": "Ada"}


async def test_a_key_with_another_name_is_refused(server: Running, http: httpx.Client) -> None:
    room, own = opened(http)
    path, headers = f"/api/v1/rooms/{room}/drops", {**own, "idempotency-key": "one"}
    names = ("Ada", "Ben", "Ada")
    asked = [http.post(path, json={"name": name}, headers=headers) for name in names]
    assert [each.status_code for each in asked] == [202, 422, 202]
    assert asked[1].json()["code"] == "key-reused"
    assert asked[0].json() == asked[2].json()
    async with playing(server.socket("triangle-8")) as player:
        await player.send(type="drop", ref="r", name="Ada")
        first = await player.until("accepted", ref="r")
        await player.send(type="drop", ref="r", name="Ben")
        assert (await player.until("error", ref="r"))["code"] == "key-reused"
        await player.send(type="drop", ref="r", name="Ada")
        assert (await player.until("accepted", ref="r")) == first


def test_balls_that_touch_each_other_have_no_tags(http: httpx.Client) -> None:
    room, own = opened(http, mode="interacting")
    answer = http.post(f"/api/v1/rooms/{room}/drops", json=TAG, headers=own)
    assert (answer.status_code, answer.json()["field"]) == (422, "name")


def test_what_falls_over_a_restart_keeps_its_tag(tmp_path: Path) -> None:
    """One ball is in the checkpoint, one was dropped after it."""
    kept = {"database_url": f"sqlite:///{tmp_path / 'plinko.db'}"}
    slow = {**TINY, "gravity": 0.01}
    flying = []
    with serving(**kept) as server, server.client() as http:
        room, own = opened(http, slow)
        path = f"/api/v1/rooms/{room}"
        http.post(f"{path}/drops", json=TAG, headers=own).raise_for_status()
    for name in ("Ben", None):
        with serving(**kept) as server, server.client() as http:
            flying = [tag_of(ball) for ball in http.get(path).json()["balls"]]
            again = {"name": name} if name else {}
            http.post(f"{path}/drops", json=again, headers=own).raise_for_status()
    assert flying == [TAG, {"name": "Ben"}]
