"""A sandbox played in a page continues in a room, at the same tick with the same bits."""

import copy
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.rooms.log import verify_log
from plinko.app.rooms.touching.story import MOST_INPUTS
from plinko.engine.constants import PHYSICS_VERSION
from tests.js.solver.test_touching import SCENES, told_by_room
from tests.kit.serving import Running, serving

NAME = "thrown and held"


def story(name: str = NAME, **changed: Any) -> dict[str, Any]:
    scene, inputs, tick = SCENES[name]
    told = {
        "scene": scene.to_dict(),
        "tick_rate": 60,
        "physics_version": PHYSICS_VERSION,
        "tick": tick,
        "inputs": [{"tick": at, "input": asked} for at, asked in inputs],
    }
    return copy.deepcopy(told) | changed


def opened(http: httpx.Client, told: dict[str, Any]) -> dict[str, Any]:
    reply = http.post("/api/v1/rooms", json={"story": told})
    assert reply.status_code == 201, reply.text
    room: dict[str, Any] = reply.json()
    return room


def positions(running: Running, room: str) -> list[float]:
    """The balls' x in a paused room."""
    found: list[float] = running.services.rooms.find(room).room.world.bodies["x"].tolist()
    return found


def paused(told: dict[str, Any]) -> dict[str, Any]:
    told["inputs"].append({"tick": told["tick"], "input": {"type": "pause", "paused": True}})
    return told


@pytest.mark.parametrize("name", SCENES)
def test_a_room_goes_on_where_a_story_ends(server: Running, http: httpx.Client, name: str) -> None:
    scene, inputs, tick = SCENES[name]
    room = opened(http, paused(story(name)))
    assert (room["tick"], room["scene"]) == (tick, scene.to_dict())
    true = told_by_room(scene, inputs, tick)[-1]["pos"]
    assert positions(server, room["id"]) == true[:-4:4]


def test_its_log_has_the_whole_story_and_verifies_and_it_belongs_to_its_creator(
    http: httpx.Client,
) -> None:
    told = paused(story())
    room = opened(http, told)
    assert (room["owned"], bool(room["token"])) == (True, True)
    log = http.get(f"/api/v1/rooms/{room['id']}/log").json()
    assert [each["tick"] for each in log["inputs"]] == [each["tick"] for each in told["inputs"]]
    assert [each["input"]["type"] for each in log["inputs"]] == [
        each["input"]["type"] for each in told["inputs"]
    ]
    assert verify_log(log).ok


def test_a_room_of_a_story_is_there_after_a_restart(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'plinko.db'}"
    with serving(database_url=url) as running, running.client() as client:
        room = opened(client, paused(story()))["id"]
        before = positions(running, room)
    with serving(database_url=url) as running, running.client() as client:
        assert client.get(f"/api/v1/rooms/{room}").json()["tick"] == SCENES[NAME][2]
        assert positions(running, room) == before


def inputs(*told: dict[str, Any], tick: int = 5) -> dict[str, Any]:
    return {"inputs": [{"tick": tick, "input": each} for each in told]}


EMPTY = {"scene": {"scene": "sandbox", "balls": 0}, "inputs": []}
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "another rate": ({"tick_rate": 50}, "tick_rate"),
    "another physics": ({"physics_version": PHYSICS_VERSION - 1}, "physics_version"),
    "no scene": ({"scene": {"scene": "moonbase"}}, "scene"),
    "an end before the last input": ({"tick": 100}, "inputs[5].tick"),
    "inputs in disorder": (
        {"inputs": [{"tick": at, "input": {"type": "clear"}} for at in (5, 4)]},
        "inputs[1].tick",
    ),
    "no such ball": (inputs({"type": "kick", "ball": 4_000, "vx": 1.0}), "inputs[0]"),
    "no such input": (inputs({"type": "explode"}), "inputs[0].input"),
    "out of range": (inputs({"type": "settings", "gravity": 1e9}), "inputs[0]"),
    "a reset": (inputs({"type": "reset"}), "inputs[0].input"),
    "too many inputs": (inputs(*[{"type": "clear"}] * (MOST_INPUTS + 1), tick=0), "inputs"),
    "hours": ({"tick": 10**7}, "story"),
    "hours of an empty box": (EMPTY | {"tick": 10**7}, "story"),
    "ages of an empty box": (EMPTY | {"tick": 10**18}, "story"),
    "endless substeps": (
        inputs({"type": "settings", "substeps": 10**400}),
        "story.inputs[0].input.substeps",
    ),
    "more substeps than a number can be divided by": (
        inputs({"type": "settings", "substeps": 10**300}),
        "story",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_story_that_cannot_be_is_refused_by_what_is_wrong(http: httpx.Client, name: str) -> None:
    changed, field = WRONG[name]
    before = len(http.get("/api/v1/rooms").json()["rooms"])
    reply = http.post("/api/v1/rooms", json={"story": story(**changed)})
    assert (reply.status_code, reply.json().get("field")) == (422, field), reply.text
    assert len(http.get("/api/v1/rooms").json()["rooms"]) == before


def test_a_note_in_a_story_nested_too_deeply_is_refused(http: httpx.Client) -> None:
    deep: Any = 1
    for _ in range(900):
        deep = [deep]
    told = story(**inputs({"type": "clear", "ref": deep}))
    reply = http.post("/api/v1/rooms", json={"story": told})
    assert (reply.status_code, reply.json()["code"]) == (400, "malformed"), reply.text
    # A story has its scene in itself.
    reply = http.post("/api/v1/rooms", json={"story": story(), "scene": "sandbox"})
    assert (reply.status_code, reply.json()["field"]) == (422, "scene")
