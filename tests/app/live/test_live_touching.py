"""Rooms of touching balls on a real server: REST, WebSocket, limits and permissions."""

import json
from typing import Any

import httpx
import pytest

from plinko.app.rooms import log as roomlog
from plinko.app.rooms.touching.room import TouchingRoom
from tests.app.conftest import TINY
from tests.kit.player import Player, playing, tick_of
from tests.kit.serving import Running, constants, serving
from tests.kit.waiting import eventually


async def opened(server: Running, **body: Any) -> dict[str, Any]:
    async with server.async_client() as http:
        reply = await http.post("/api/v1/rooms", json=body)
        assert reply.status_code == 201, reply.text
        room: dict[str, Any] = reply.json()
        return room


async def mine(player: Player, room: dict[str, Any]) -> Player:
    """Claim the room with its owner's token."""
    await player.send(type="claim", token=room["token"])
    await player.until("claimed")
    return player


async def picture(player: Player) -> Any:
    """The next snapshot's balls."""
    while True:
        frame = await player.step()
        if isinstance(frame, bytes):
            return player.decode(frame).balls


def test_scenes_are_listed_with_rooms_ranges_and_presets(http: httpx.Client) -> None:
    listed = http.get("/api/v1/scenes").json()
    rooms = {scene["name"]: scene["room"] for scene in listed["scenes"]}
    assert rooms == {"sandbox": "sandbox", "galton": "galton-pile"}
    assert listed["presets"]["gravity"]["Jupiter"] == 24.79
    assert len(listed["presets"]["restitution"]) >= 6
    assert listed["ranges"]["settings"]["damping"]["low"] == 0.9
    names = [board["name"] for board in http.get("/api/v1/boards").json()["boards"]]
    assert "sandbox" not in names, "a box has no bins and is no board"


async def test_a_sandbox_of_ones_own_over_rest_and_played(server: Running) -> None:
    scene = {"scene": "sandbox", "balls": 20, "seed": "7", "gravity": "Mars", "radii": [0.05, 0.1]}
    room = await opened(server, scene=scene)
    assert (room["mode"], room["solver"], room["owned"]) == ("scene", "stepped", True)
    assert room["scene"]["gravity"] == 3.72
    async with playing(server.socket(room["id"])) as player:
        arena = player.hello["arena"]
        assert player.hello["mode"] == "interacting"
        assert player.hello["board"] is None
        assert len(arena["balls"]["radius"]) == 20
        assert all(0.05 <= radius <= 0.1 for radius in arena["balls"]["radius"])
        balls = await picture(player)
        assert len(balls) == 20, "a picture comes with the hello"
        await mine(player, room)
        await player.send(type="add", x=0.0, y=0.5, vx=5.0, vy=-1.0, radius=0.2, ref="throw")
        placed = await player.until("placed", ref="throw")
        assert placed["radius"] == 0.2
        balls = await picture(player)
        while placed["ball"] not in balls["id"]:
            balls = await picture(player)
        (thrown,) = balls[balls["id"] == placed["ball"]]
        assert thrown["vx"] > 3.0
        await player.send(type="remove", ball=placed["ball"])
        await player.until("removed", balls=[placed["ball"]])


async def test_only_a_room_s_creator_changes_it_a_public_one_everybody(server: Running) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 1})
    async with playing(server.socket(room["id"])) as guest:
        assert guest.hello["arena"]["owned"] is True
        await guest.send(type="kick", ball=0, vx=1.0, ref=1)
        refused = await guest.until("error", ref=1)
        assert refused["code"] == "not-yours"
        await guest.send(type="claim", token="x" * 43, ref=2)
        assert (await guest.until("error", ref=2))["code"] == "not-yours"
        assert room["token"] not in "".join(guest.texts)
    async with playing(server.socket("sandbox")) as anyone:
        assert anyone.hello["arena"]["owned"] is False
        await anyone.send(type="add", x=0.0, y=1.0, ref=3)
        await anyone.until("placed", ref=3)
        await anyone.send(type="reset")
        hello = await anyone.until("hello")
        assert len(hello["arena"]["balls"]["ball"]) == hello["arena"]["scene"]["balls"]
    # A room of independent balls cannot be changed.
    async with playing(server.socket("main")) as player:
        await player.send(type="add", x=0.0, y=1.0, ref=1)
        refused = await player.until("error", ref=1)
        assert "independent balls" in refused["detail"]


async def test_an_interacting_table_has_the_events_of_any_table(server: Running) -> None:
    room = (await opened(server, board=TINY, mode="interacting"))["id"]
    async with playing(server.socket(room)) as player:
        assert (player.hello["mode"], player.hello["solver"]) == ("interacting", "stepped")
        assert player.hello["stream"] == "snapshots"
        assert player.hello["board"]["name"] == "tiny"
        for seed in range(6):
            await player.send(type="drop", seed=seed, ref=seed)
        while player.kinds().count("landed") < 6:  # two that land in one tick share a message
            await player.step()
        accepted = [event for event in player.events if event["type"] == "accepted"]
        assert [event["seed"] for event in accepted] == [str(seed) for seed in range(6)]
        landed = [event for event in player.events if event["type"] == "landed"]
        assert {event["ball"] for event in landed} == {event["ball"] for event in accepted}
        assert any(event["type"] == "contact" and event["kind"] == 0 for event in player.events)
    async with server.async_client() as http:
        view = (await http.get(f"/api/v1/rooms/{room}")).json()
        reply = await http.post(f"/api/v1/rooms/{room}/drops?wait=1", json={"seed": 3})
    assert sum(view["stats"]["histogram"]) + view["stats"]["unsettled"] >= 6
    assert reply.status_code == 200
    assert reply.json()["landed"]["seed"] == "3"


async def test_diagnostics_come_a_few_times_a_second_on_request(
    server: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 10, "restitution": 0.9})
    computed, compute = list[str](), TouchingRoom.diagnostics

    def noted(self: TouchingRoom) -> Any:
        computed.append(self.id)
        return compute(self)

    monkeypatch.setattr(TouchingRoom, "diagnostics", noted)
    async with playing(server.socket(room["id"])) as one, playing(server.socket(room["id"])) as two:
        for player in (one, two):
            await mine(player, room)
        await one.send(type="settings", gravity=9.0)
        await one.until("settings")
        for _ in range(30):
            await picture(one)
        assert room["id"] not in computed, "nothing is computed when nobody asked"
        await one.send(type="watch", diagnostics=True)
        first = await one.until("diagnostics")
        start = tick_of(one.binaries[-1])
        for _ in range(4):
            last = await one.until("diagnostics")
        ticks = tick_of(one.binaries[-1]) - start
        assert 36 <= ticks <= 72, "about five times a second of the room's time"
        assert first["count"] == last["count"] == 10
        assert last["total"] == pytest.approx(
            last["kinetic"] + last["potential"] + last["rotational"]
        )
        assert last["total"] <= first["total"] + 1e-6
        await one.send(type="watch", diagnostics=False)
        await one.send(type="ping", t=1)
        await one.until("pong")
        asked = computed.count(room["id"])
        for _ in range(30):
            await picture(one)
        assert computed.count(room["id"]) == asked
        assert "diagnostics" not in two.kinds()


async def test_a_stopped_clock_shows_changes_and_sends_nothing_else(
    server: Running,
) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 4})
    async with playing(server.socket(room["id"])) as player:
        await mine(player, room)
        await player.send(type="pause", paused=True)
        told = await player.until("settings", paused=True)
        await player.send(type="add", x=0.0, y=2.0, ref=1)
        placed = await player.until("placed", ref=1)
        balls = await picture(player)
        while len(balls) < 5:
            balls = await picture(player)
        assert placed["tick"] == told["tick"], "the clock stands"
        await eventually(
            lambda: room["id"] not in [r.id for r in server.services.rooms.runner.awake]
        )
        sent = len(player.binaries)
        await player.send(type="ping", t=1)
        await player.until("pong")
        assert len(player.binaries) == sent
        await player.send(type="step")
        await picture(player)
        assert player.decode(player.binaries[-1]).tick == told["tick"] + 1


async def test_the_log_of_a_played_room_verifies_and_a_hand_that_goes_away_lets_go(
    server: Running,
) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 12, "dt": 1 / 120})
    live: Any = server.services.rooms.find(room["id"]).room
    async with playing(server.socket(room["id"])) as player:
        await mine(player, room)
        await player.send(type="add", x=0.0, y=0.5, vx=3.0, ref=1)
        ball = (await player.until("placed", ref=1))["ball"]
        for step in range(10):
            await player.send(type="drag", ball=ball, x=0.1 * step, y=1.0)
            await picture(player)
        await player.send(type="release", ball=ball)
        await player.send(type="kick", ball=0, vx=2.0, vy=-4.0)
        await player.send(type="settings", gravity="Jupiter", restitution=0.1)
        await player.until("settings")
        for _ in range(20):
            await picture(player)
        await player.send(type="drag", ball=0, x=0.0, y=1.0)
        await eventually(lambda: live.world.holds)
    await eventually(lambda: not live.world.holds)
    async with server.async_client() as http:
        text = (await http.get(f"/api/v1/rooms/{room['id']}/log")).text
    log = json.loads(text)
    assert {entry["input"]["type"] for entry in log["inputs"]} == {
        "add", "drag", "release", "kick", "settings",
    }  # fmt: skip
    assert roomlog.verify_log(log).ok
    bent = json.loads(text.replace('"vy":-4.0', '"vy":-4.5'))
    assert roomlog.verify_log(bent).field == "world_digest"


async def test_changes_too_fast_and_balls_too_many_are_refused() -> None:
    changed = {
        "plinko.app.web.routes.rooms.room_changes.CHANGE_RATE": 5.0,
        "plinko.app.rooms.kinds.MAX_TOUCHING": 3,
    }
    with constants(**changed), serving(drop_rate=1000.0) as server:
        async with playing(server.socket("interacting-triangle-8")) as player:
            for ref in range(100):  # at once: more than 5 a second even on a slow machine
                y = 0.5 + 0.1 * (ref % 12)
                await player.send(type="add", x=0.0, y=y, radius=0.02, ref=ref)
            codes = [(await player.until("error"))["code"] for _ in range(97)]
            assert set(codes) == {"too-many-balls", "rate-limited"}
            while player.kinds().count("placed") < 3:
                await player.step()
            for ref in range(60):
                await player.send(type="kick", ball=999, ref=ref)
            await player.send(type="ping", t=1)
            await player.until("pong")


async def test_a_scene_is_spelt_alike_wherever_it_is_written_and_read(server: Running) -> None:
    wanted = {"scene": "sandbox", "balls": 3, "gravity": "Mars", "seed": 5}
    room = await opened(server, scene=wanted)
    async with playing(server.socket(room["id"])) as player:
        assert player.hello["arena"]["scene"] == room["scene"]
        await mine(player, room)
        for scene, balls in ((wanted | {"balls": 2}, 2), (room["scene"], 3), ("sandbox", 60)):
            await player.send(type="reset", scene=scene)
            hello = await player.until("hello")
            assert hello["arena"]["scene"]["balls"] == balls
    async with server.async_client() as http:
        again = (await http.get(f"/api/v1/rooms/{room['id']}")).json()["scene"]
        log = (await http.get(f"/api/v1/rooms/{room['id']}/log")).json()
    assert room["scene"] == again == log["scene"]
    assert log["inputs"][1]["input"] == {"type": "reset", "scene": room["scene"]}


def test_a_scene_may_come_with_a_null_board_and_with_no_other(http: httpx.Client) -> None:
    said = {"scene": {"scene": "sandbox", "balls": 2}, "board": None}
    room = http.post("/api/v1/rooms", json=said).raise_for_status().json()
    head = {"authorization": f"Bearer {room['token']}"}
    reply = http.patch(f"/api/v1/rooms/{room['id']}", json={"board": "classic"}, headers=head)
    assert reply.status_code == 422
    assert "scene" in reply.json()["detail"]
    assert http.post(f"/api/v1/rooms/{room['id']}/reset", headers=head).status_code == 200


async def test_only_changes_with_a_note_are_answered(server: Running) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 0})
    async with playing(server.socket(room["id"])) as player:
        usual = player.hello["arena"]["ranges"]["ball"]["radius"]["default"]
        await mine(player, room)
        await player.send(type="add", x=0.0, y=1.0, ref="mine")
        placed = await player.until("placed")
        assert (placed["ref"], placed["radius"]) == ("mine", usual)
        ball = placed["ball"]
        changes: list[dict[str, Any]] = [
            {"type": "kick", "ball": ball, "vx": 0.1},
            {"type": "drag", "ball": ball, "x": 0.0, "y": 1.0},
            {"type": "release", "ball": ball},
            {"type": "edit", "ball": ball, "density": 5.0},
            {"type": "pause", "paused": True},
            {"type": "step"},
            {"type": "settings", "gravity": 1.0},
            {"type": "clear"},
        ]
        for number, change in enumerate(changes):
            if change["type"] != "clear":
                await player.send(**change)
            await player.send(**change, ref=[number])
            assert (await player.until("done"))["ref"] == [number]
        assert player.kinds().count("done") == len(changes)
        assert player.kinds().count("error") == 0


async def test_a_scene_that_is_reset_has_another_run_whichever_way(
    server: Running, http: httpx.Client
) -> None:
    room = await opened(server, scene={"scene": "sandbox", "balls": 1})
    token = {"authorization": f"Bearer {room['token']}"}
    async with playing(server.socket(room["id"])) as player:
        runs = [player.hello["run"]]
        await mine(player, room)
        await player.send(type="reset")
        runs.append((await player.until("hello"))["run"])
        assert http.post(f"/api/v1/rooms/{room['id']}/reset", headers=token).status_code == 200
        runs.append((await player.until("hello"))["run"])
        await player.send(type="resume", run=runs[0], since=0, key=player.hello["key"])
        assert (await player.until("missed"))["events"] is None
    assert len(set(runs)) == 3
