"""Pictures of rooms of touching balls: many sizes, sleeping balls in grey, reset scenes."""

import asyncio
from typing import Any

import httpx
import numpy as np
import pytest

from plinko.app.errors import InvalidValueError
from plinko.app.pictures.film import Shot
from plinko.app.pictures.frame import stage_of, still_of
from plinko.app.protocol.touching_messages import AddMessage, Change, ResetMessage
from plinko.app.render import BoxStage
from plinko.app.render.theme import THEMES
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import Board
from plinko.engine.multibody.scenes import sandbox
from plinko.engine.multibody.static_geometry import StaticGeometry
from tests.app.conftest import TINY
from tests.app.pictures.test_film import (
    decode,
    filming,
    never_pausing,
    picture_in,
    redness,
    settled,
)

WIDTH = 500


def box_room(**scene: Any) -> TouchingRoom:
    found = Scene.of({"scene": "sandbox", **scene}, tick_rate=60, max_balls=300)
    return TouchingRoom("r", found, tick_rate=60, max_balls=300)


def add(room: TouchingRoom, x: float, y: float, radius: float) -> None:
    change(room, AddMessage(x=x, y=y, radius=radius))


def change(room: TouchingRoom, message: Change) -> None:
    room.plan_change(message).durable = True
    room.enter()


def frame_of(room: TouchingRoom) -> tuple[Any, Any]:
    """The stage that draws a room, and the room's picture."""
    still = still_of(room)
    stage = stage_of(still.scenery, WIDTH, "light")
    return stage, stage.frame(still.bodies, facts=still.facts).astype(int)


def colour_at(stage: Any, pixels: Any, x: float, y: float) -> Any:
    return pixels[int(stage.view.py(y)), int(stage.view.px(x))]


def test_each_ball_of_a_box_is_as_large_as_it_is() -> None:
    room = box_room(balls=0)
    sizes = {-2.0: 0.08, 0.0: 0.2, 2.0: 0.5}
    bare = frame_of(room)[1]
    for x, radius in sizes.items():
        add(room, x, 1.5, radius)
    stage, pixels = frame_of(room)
    rows = slice(int(stage.view.header), None)
    for x, radius in sizes.items():
        columns = slice(int(stage.view.px(x - 0.8)), int(stage.view.px(x + 0.8)))
        new = np.abs(pixels - bare)[rows, columns].max(axis=-1) > 30
        across = new.any(axis=0).sum()  # the shadow widens it a little to the right
        wide = 2.0 * radius * stage.view.scale
        assert wide - 1.0 <= across <= 1.2 * wide + 2.0
        centre = stage.view.px(x), stage.view.py(1.5)
        assert redness(pixels, *centre, int(0.7 * radius * stage.view.scale)) > 0.3


def test_sleeping_balls_are_grey() -> None:
    arena = sandbox(12, seed=3, speed=0.0, drag=0.5)
    while arena.awake:
        arena.step()
    arena.add(0.0, 1.0, radius=0.2)
    stage = BoxStage(arena.place, WIDTH)
    pixels = stage.frame(arena.bodies).astype(int)
    for body in arena.bodies:
        reach = int(0.6 * body["radius"] * stage.view.scale)
        x, y = stage.view.px(float(body["x"])), stage.view.py(float(body["y"]))
        red = redness(pixels, x, y, max(reach, 1))
        assert red == 0.0 if body["asleep"] else red > 0.3


def test_a_box_has_rails_outside_and_pegs_and_bins_inside() -> None:
    rail = np.array(THEMES["light"]["rail"])
    stage = BoxStage(StaticGeometry.box(4.0, 3.0), WIDTH)
    pixels = stage.frame(sandbox(0).bodies).astype(int)
    edge = 1.0 / stage.view.scale  # metres per pixel
    for x, y in ((-2.0 - edge, 1.5), (2.0 + edge, 1.5), (0.3, -edge), (0.3, 3.0 + edge)):
        assert (colour_at(stage, pixels, x, y) == rail).all()
    for x, y in ((-2.0 + edge, 1.5), (2.0 - edge, 1.5), (0.3, 3.0 - edge)):
        assert abs(colour_at(stage, pixels, x, y) - rail).max() > 60
    board = Board.preset("triangle-8")
    on_board = BoxStage(StaticGeometry.of_board(board), WIDTH)
    pixels = on_board.frame(sandbox(0).bodies).astype(int)
    for peg in board.pegs:
        assert (colour_at(on_board, pixels, peg.x, peg.y) == THEMES["light"]["peg"]).all()
    middle = 0.5 * (board.bins.edges[3] + board.bins.edges[4])
    line = colour_at(on_board, pixels, middle, board.bins.y)
    assert abs(line - np.array(THEMES["light"]["trayMark"])).max() < 80
    # A tall box's picture is bounded, and a bad size is named.
    stage = BoxStage(StaticGeometry.box(0.5, 20.0), 240)
    assert stage.view.height <= 2.5 * 240 + 60
    assert 0 < stage.view.px(-0.25) < stage.view.px(0.25) < 240
    with pytest.raises(InvalidValueError, match="width 10"):
        BoxStage(StaticGeometry.box(1.0, 1.0), 10)


def test_a_png_of_a_box_shows_what_the_pixels_are() -> None:
    room = box_room(balls=40)
    for _ in range(60):
        room.step(watched=False)
    stage, pixels = frame_of(room)
    drawn = pixels.astype(np.uint8)
    assert abs(decode(stage.png(drawn)) - pixels).mean() < 0.8
    assert abs(decode(stage.jpg(drawn)) - pixels).mean() < 4.0


def test_balls_that_knock_each_other_are_drawn_on_their_board() -> None:
    board = Board.from_json(TINY)
    room = TouchingRoom("r", board, tick_rate=60, max_balls=9)
    room.drop(DropCommand(1))
    for _ in range(10):
        room.step(watched=False)
    stage, pixels = frame_of(room)
    assert stage.board == board
    (body,) = room.world.bodies
    x, y = stage.view.px(float(body["x"])), stage.view.py(float(body["y"]))
    assert redness(pixels, x, y, int(board.ball.radius * stage.view.scale)) > 0.3
    assert still_of(room).facts == ("1 in flight", "0 landed")


async def test_a_camera_goes_on_when_another_scene_is_begun() -> None:
    async with filming() as cameras:
        room = box_room(balls=5)
        camera, seen, part = await cameras.open(room, Shot("r", 240, "light", 60))
        first = picture_in(part).shape
        waiting = asyncio.create_task(camera.newest(seen))
        await asyncio.sleep(0)
        change(room, ResetMessage(scene={"scene": "galton", "balls": 20}))
        room.step(watched=False)
        cameras.ticked(0.0, 0.0)
        _, part = await waiting
        assert picture_in(part).shape != first


async def test_a_box_at_rest_is_drawn_again_only_after_an_input() -> None:
    async with filming() as cameras:
        room = box_room(balls=0)
        never_pausing(cameras)
        camera, seen, _ = await cameras.open(room, Shot("r", 240, "light", 60))
        waiting = asyncio.create_task(camera.newest(seen))
        cameras.ticked(0.0, 0.0)
        await settled(cameras)
        assert cameras.drawn == 1
        add(room, 0.0, 1.0, 0.3)
        cameras.ticked(0.0, 0.0)
        _, part = await waiting
        view = stage_of(still_of(room).scenery, 240, "light").view
        assert redness(picture_in(part), view.px(0.0), view.py(1.0), 6) > 0.3


@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_scenes_and_tables_of_touching_balls_have_frames(http: httpx.Client, suffix: str) -> None:
    for name in ("sandbox", "interacting-triangle-8"):
        reply = http.get(f"/api/v1/rooms/{name}/frame.{suffix}?width=300&theme=dark")
        assert reply.status_code == 200, reply.text
        assert decode(reply.content).shape[1] == 300
    room = http.post("/api/v1/rooms", json={"scene": {"scene": "sandbox", "balls": 0}}).json()
    path = f"/api/v1/rooms/{room['id']}"
    first = http.get(f"{path}/frame.{suffix}")
    tag = {"if-none-match": first.headers["etag"]}
    assert http.get(f"{path}/frame.{suffix}", headers=tag).status_code == 304
