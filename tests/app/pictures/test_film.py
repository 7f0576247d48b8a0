"""Live pictures are drawn only while a client watches and a ball moves, once for all clients."""

import asyncio
import io
import itertools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from plinko.app.errors import BusyError, InvalidValueError, RoomFullError
from plinko.app.pictures.film import BOUNDARY, LIT_SECONDS, PART_HEAD, Cameras, Shot
from plinko.app.pictures.frame import still_of
from plinko.app.render import Stage
from plinko.app.render.raster.palette import Palette
from plinko.app.render.theme import THEMES
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.app.web.limits import Budgets
from plinko.engine import Board, World
from tests.app.conftest import QUICK, TINY
from tests.kit.serving import Running, constants, serving
from tests.kit.waiting import eventually, turns

RED = THEMES["light"]["ball"]
SHOT = Shot("r", 240, "light", 60)


def decode(picture: bytes) -> Any:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def picture_in(part: bytes) -> Any:
    """The picture in a part of the stream, which must end with the next part's head."""
    end = b"\r\n" + PART_HEAD
    assert part.endswith(end)
    assert f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode() == PART_HEAD
    return decode(part.removesuffix(end))


def redness(pixels: Any, x: float, y: float, reach: int) -> float:
    around = pixels[int(y) - reach : int(y) + reach, int(x) - reach : int(x) + reach]
    return float((np.sqrt(((around - np.array(RED)) ** 2).sum(axis=-1)) < 110).mean())


# the stage


def test_a_frame_shows_each_ball_and_else_the_board() -> None:
    world = World(Board.preset("triangle-8"))
    stage = Stage(world.board, 500)
    bare = stage.frame(world.bodies).astype(int)
    for seed in range(8):
        world.add(seed)
        for _ in range(15):
            world.step()
    pixels = stage.frame(world.bodies).astype(int)
    view, radius = stage.view, world.board.ball.radius * stage.view.scale
    touched = np.zeros(pixels.shape[:2], bool)
    for body in world.bodies:
        x, y = view.px(float(body["x"])), view.py(float(body["y"]))
        assert redness(pixels, x, y, int(radius)) > 0.3
        reach = 1.6 * radius + 2
        touched[max(int(y - reach), 0) : int(y + reach), int(x - reach) : int(x + reach)] = True
    assert (pixels[~touched] == bare[~touched]).all()
    assert not (pixels == bare).all()
    stage.frame(world.bodies, lit=[0, 8])
    assert (stage.frame(world.bodies[:0]) == bare).all(), "the layer is not painted on"


def test_a_lit_bin_has_a_rim_and_facts_stand_in_the_strip() -> None:
    stage = Stage(Board.preset("triangle-8"), 500)
    nobody = World(stage.board).bodies
    plain, lit = stage.frame(nobody), stage.frame(nobody, lit=[3])
    rows, columns = np.nonzero((plain != lit).any(axis=-1))
    edges = stage.view.px(np.array(stage.board.bins.edges))
    assert edges[3] - 5 <= columns.min() < columns.max() <= edges[4] + 5
    assert rows.min() > stage.view.bin_top - 5
    told = stage.frame(nobody, facts=["7 in flight"])
    rows, _ = np.nonzero((plain != told).any(axis=-1))
    assert len(rows)
    assert rows.max() < stage.view.header
    assert (stage.frame(nobody) == plain).all()


def test_a_live_png_shows_what_the_pixels_are() -> None:
    world = World(Board.preset("triangle-16"))
    stage = Stage(world.board)
    for seed in range(30):
        world.add(seed)
        for _ in range(7):
            world.step()
    pixels = stage.frame(world.bodies)
    assert abs(decode(stage.png(pixels)) - pixels).mean() < 0.6
    assert abs(decode(stage.jpg(pixels)) - pixels).mean() < 4.0
    assert isinstance(stage._palette, Palette)


# cameras, with a room at hand


@asynccontextmanager
async def filming(max_cameras: int = 2, max_viewers: int = 60) -> AsyncIterator[Cameras]:
    cameras = Cameras(max_cameras, max_viewers)
    try:
        yield cameras
    finally:
        cameras.close()
        await asyncio.sleep(0)


def room_of(board: dict[str, Any] = TINY) -> IndependentRoom:
    return IndependentRoom("r", Board.from_json(board), tick_rate=60, max_balls=100)


def advance(room: IndependentRoom, cameras: Cameras, ticks: int = 1) -> None:
    for _ in range(ticks):
        room.step(watched=False)
        cameras.ticked(0.0, 0.0)


async def test_fifty_viewers_get_the_same_bytes_drawn_once() -> None:
    async with filming() as cameras:
        room = room_of()
        opened = [await cameras.open(room, SHOT) for _ in range(50)]
        assert cameras.drawn == 1
        assert len({id(part) for _, _, part in opened}) == 1
        room.drop(DropCommand(1))
        waiting = [asyncio.create_task(camera.newest(seen)) for camera, seen, _ in opened]
        await asyncio.sleep(0)
        advance(room, cameras, 3)
        frames = await asyncio.gather(*waiting)
        assert cameras.drawn == 2
        assert len({id(part) for _, part in frames}) == 1
        assert cameras.viewers == 50
        assert cameras.running == 1
        # A frame shows balls where they are.
        view = Stage(room.board, SHOT.width).view
        (body,) = room.world.bodies
        x, y = view.px(float(body["x"])), view.py(float(body["y"]))
        radius = int(room.board.ball.radius * view.scale)
        assert redness(picture_in(frames[0][1]), x, y, radius) > 0.3


def never_pausing(cameras: Cameras) -> None:
    """Set a clock on which every frame is due: cameras draw whenever the room has changed."""
    cameras._clock = itertools.count(0.0, 1.0).__next__


async def settled(cameras: Cameras) -> None:
    """Wait until every camera waits for a change in its room."""
    for _ in range(2):
        await turns()
        await eventually(lambda: cameras._workers.jobs == 0)


async def test_nothing_is_drawn_without_viewers_or_of_an_idle_room() -> None:
    async with filming() as cameras:
        room = room_of()
        room.drop(DropCommand(1))
        advance(room, cameras, 10)
        assert (cameras.drawn, cameras.running) == (0, 0)
        never_pausing(cameras)
        camera, seen, _ = await cameras.open(room, SHOT)
        assert cameras.films("r")
        more = asyncio.create_task(camera.newest(seen))
        await settled(cameras)
        assert cameras.drawn == 1  # time passed, but the room did not move
        advance(room, cameras)
        await more
        for _ in range(5):  # the room moves, but no client waits for a frame
            advance(room, cameras)
            await settled(cameras)
        assert cameras.drawn == 2
        cameras.leave(camera)
        assert (cameras.running, cameras.viewers, cameras.drawn) == (0, 0, 2)
        assert not cameras.films("r")
        advance(room, cameras, 3)
        await settled(cameras)
        assert cameras.drawn == 2


async def test_a_slow_viewer_gets_the_newest_and_delays_no_other() -> None:
    async with filming() as cameras:
        room = room_of()
        room.drop(DropCommand(1))
        slow, seen_slow, _ = await cameras.open(room, SHOT)
        fast, seen, _ = await cameras.open(room, SHOT)
        for _ in range(4):
            advance(room, cameras)
            seen, newest = await fast.newest(seen)
        assert await slow.newest(seen_slow) == (seen, newest)
        assert seen == seen_slow + 4


async def test_a_camera_keeps_to_its_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten frames a second, each of which takes a hundredth of a second to draw."""
    now, real = [50.0], asyncio.sleep

    here = asyncio.get_running_loop()

    async def sleep(seconds: float) -> None:
        if asyncio.get_running_loop() is not here:  # another test's server in this process
            await real(seconds)
            return
        now[0] += seconds
        await real(0)

    async with filming() as cameras:
        cameras._clock = lambda: now[0]
        room = room_of()
        room.drop(DropCommand(1))
        monkeypatch.setattr("plinko.app.pictures.film.asyncio.sleep", sleep)
        camera, seen, _ = await cameras.open(room, Shot("r", 240, "light", 10))
        came = []
        for _ in range(5):
            now[0] += 0.01
            advance(room, cameras)
            seen, _ = await camera.newest(seen)
            came.append(now[0])
        assert np.diff(came) == pytest.approx(0.1, abs=1e-6)


async def test_a_bin_lights_up_and_goes_out_while_the_room_sleeps() -> None:
    async with filming() as cameras:
        now = [100.0]
        cameras._clock = lambda: now[0]
        room = room_of()
        room.drop(DropCommand(1))
        camera, seen, part = await cameras.open(room, SHOT)
        dark = picture_in(part)
        assert still_of(room).facts == ("1 in flight", "0 landed")
        while room.awake:
            advance(room, cameras)
        assert still_of(room).facts == ("0 in flight", "1 landed")
        now[0] += 0.1
        seen, part = await camera.newest(seen)
        lit = picture_in(part)
        assert abs(lit - dark)[-30:].max() > 60
        now[0] += LIT_SECONDS
        advance_nothing = asyncio.create_task(camera.newest(seen))
        camera._moved.set()
        _, part = await advance_nothing
        assert abs(picture_in(part) - dark)[-30:].max() < 40


async def test_viewers_pay_and_wait_when_their_budget_is_empty() -> None:
    now = [50.0]
    budgets = Budgets(rate=0.5, burst=0.001)
    async with filming() as cameras:
        cameras._clock = lambda: now[0]
        cameras._budget = budgets
        room = room_of()
        camera, _, _ = await cameras.open(room, SHOT, "10.0.0.1")
        wait = budgets.wait("10.0.0.1", now[0])
        assert wait > 0.0, "a picture takes more than a millisecond"
        assert camera._until_paid() == wait
        await cameras.open(room, SHOT, "10.0.0.2")
        assert camera._until_paid() == 0.0
        camera._charge(6.0)
        assert budgets.wait("10.0.0.1", now[0]) == pytest.approx(wait + 6.0)
        assert budgets.wait("10.0.0.2", now[0]) == pytest.approx((3.0 - 0.001) / 0.5)
        cameras.leave(camera, "10.0.0.1")
        assert camera.viewers == {"10.0.0.2": 1}


async def test_cameras_and_viewers_are_bounded() -> None:
    async with filming(max_cameras=1, max_viewers=2) as cameras:
        room = room_of()
        await cameras.open(room, SHOT)
        with pytest.raises(BusyError, match="1 cameras"):
            await cameras.open(room, Shot("r", 300, "light", 60))
        await cameras.open(room, SHOT)
        with pytest.raises(RoomFullError, match="2 viewers"):
            await cameras.open(room, SHOT)
    # An impossible shot is refused before it is filmed.
    for width, theme, field in ((7, "light", "width"), (300, "pink", "theme")):
        with pytest.raises(InvalidValueError) as refused:
            Shot("r", width, theme, 25)
        assert refused.value.field == field


async def test_a_failed_camera_raises_at_its_viewer_and_is_removed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("plinko.app.pictures.film.draw", len)  # fails, as len takes one argument
    async with filming() as cameras:
        with pytest.raises(TypeError):
            await cameras.open(room_of(), SHOT)
        assert (cameras.running, cameras.viewers) == (0, 0)


# over HTTP


def new_room(http: httpx.Client, board: Any = TINY) -> str:
    room: str = http.post("/api/v1/rooms", json={"board": board}).json()["id"]
    return room


@pytest.mark.parametrize(("suffix", "fmt"), [("png", "PNG"), ("jpg", "JPEG")])
def test_a_rooms_frame_has_a_tag_that_changes_when_it_moves(
    http: httpx.Client, suffix: str, fmt: str
) -> None:
    path = f"/api/v1/rooms/{new_room(http, QUICK)}"
    frame = f"{path}/frame.{suffix}?width=300"
    response = http.get(frame)
    assert response.status_code == 200
    with Image.open(io.BytesIO(response.content)) as picture:
        assert (picture.format, picture.width) == (fmt, 300)
    assert response.headers["cache-control"] == "no-cache"
    tag = {"if-none-match": response.headers["etag"]}
    assert http.get(frame, headers=tag).status_code == 304
    http.post(f"{path}/drops?wait=1", json={"seed": "1"})
    moved = http.get(frame, headers=tag)
    assert moved.status_code == 200
    assert moved.content != response.content
    assert http.get(f"{path}/frame.{suffix}?width=9").status_code == 422
    assert http.get(f"/api/v1/rooms/nope/frame.{suffix}").status_code == 404


async def parts(response: httpx.Response) -> AsyncIterator[bytes]:
    """The parts of a stream, each with the next part's head; the first begins the stream."""
    rest, end, opened = b"", b"\r\n" + PART_HEAD, False
    async for chunk in response.aiter_raw():
        rest += chunk
        if not opened and len(rest) >= len(PART_HEAD):
            assert rest.startswith(PART_HEAD)
            rest, opened = rest.removeprefix(PART_HEAD), True
        while opened and (at := rest.find(end)) >= 0:
            yield rest[: at + len(end)]
            rest = rest[at + len(end) :]


async def test_a_stream_shows_a_fall_to_all_and_ends_with_them(
    server: Running, http: httpx.Client
) -> None:
    room = new_room(http)
    url = f"{server.url}/api/v1/rooms/{room}/stream.mjpg?width=240&fps=60"
    cameras = server.services.computing.cameras

    seen: list[set[bytes]] = [set(), set(), set()]

    async def watch(client: httpx.AsyncClient, found: set[bytes]) -> None:
        async with client.stream("GET", url) as response:
            assert response.headers["content-type"].startswith("multipart/x-mixed-replace")
            async for part in parts(response):
                picture_in(part)
                found.add(part)
                if len(set.union(*seen)) >= 6 and len(set.intersection(*seen)) >= 3:
                    break

    async with httpx.AsyncClient(timeout=60) as client:
        watching = [asyncio.create_task(watch(client, found)) for found in seen]
        await eventually(lambda: cameras.viewers == 3)
        assert cameras.films(room)
        drawn = cameras.drawn
        for seed in itertools.count():  # a camera may wait long for a worker
            await client.post(f"{server.url}/api/v1/rooms/{room}/drops?wait=1", json={"seed": seed})
            if all(each.done() for each in watching):
                break
        await asyncio.gather(*watching)
    await eventually(lambda: cameras.viewers == 0)
    assert not cameras.films(room)
    assert cameras.drawn > drawn


def test_a_server_that_stops_ends_its_streams() -> None:
    forever = {"plinko.app.listening.SHUTDOWN_SECONDS": 3600}
    with constants(**forever), serving(database_url="sqlite://") as running:
        url = f"{running.url}/api/v1/rooms/main/stream.mjpg?width=240"
        with httpx.Client(timeout=60) as client, client.stream("GET", url) as response:
            chunks = response.iter_raw()
            first = next(chunks)
            running.uvicorn.should_exit = True
            whole = b"".join([first, *chunks])
        assert picture_in(whole.removeprefix(PART_HEAD)).shape[1] == 240


def test_too_many_streams_are_told_when_to_come_back(
    server: Running, http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server.services.computing.cameras, "max_cameras", 0)
    refused = http.get("/api/v1/rooms/main/stream.mjpg")
    assert refused.status_code == 503
    assert int(refused.headers["retry-after"]) >= 1


def test_a_room_that_is_filmed_stays_open(server: Running, http: httpx.Client) -> None:
    rooms = server.services.rooms
    http.get("/api/v1/rooms/triangle-9-low").raise_for_status()
    room = rooms.find("triangle-9-low")
    assert not rooms._open.is_used(room)
    with http.stream("GET", "/api/v1/rooms/triangle-9-low/stream.mjpg") as viewed:
        pieces = viewed.iter_raw()
        assert next(pieces)
        assert rooms._open.is_used(room)
