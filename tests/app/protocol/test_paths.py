"""The stream `paths`: a ball drawn from its one message follows the path of the drop."""

from itertools import pairwise
from typing import Any

import httpx
import numpy as np
import pytest

from plinko.app.errors import InvalidValueError
from plinko.app.protocol import client_messages, paths
from plinko.app.protocol.paths import LEAD, MOST_KNOTS, current_parts, due_parts, path_of
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.engine import Board, ParameterError, World, drop
from plinko.engine.constants import KIND_PEG, KIND_WALL
from plinko.engine.drops.flight import Flight, fly
from plinko.engine.drops.start import start_of
from tests.kit.player import playing
from tests.kit.serving import Running
from tests.long import tries
from tests.outsider import decoder

BOARDS = ("triangle-8", "triangle-12", "triangle-16", "classic", "galton")

ERROR = 0.15e-3  # m, the largest on presets: 0.015 pixels at 100 pixels a metre
SAMPLES = 300


def flight_of(board: Board, seed: int) -> Flight:
    return fly(board, start_of(board, seed, None, None))


def elastic(name: str = "triangle-8") -> Board:
    """A preset without losses: some of its balls bounce for 1,000 s, thousands of times."""
    form = Board.preset(name).to_dict()
    return Board.from_json({**form, "drag": 0.0, "ball": {**form["ball"], "restitution": 1.0}})


def errors(board: Board, flight: Flight, knots: list[decoder.Row]) -> tuple[float, float]:
    """The largest errors of a drawn flight: of its place in m, and of its angle in rad."""
    times = np.linspace(0.0, flight.duration, SAMPLES)
    drawn = np.array([decoder.pose(knots, t, board.drag) for t in times.tolist()])
    _, x, y, _, _, angle, _ = flight.trajectory.states_at(times).T
    off = np.hypot(drawn[:, 0] - x, drawn[:, 1] - y)
    return float(off.max()), float(np.abs(drawn[:, 2] - angle).max())


@pytest.mark.parametrize("name", BOARDS)
def test_drawn_from_the_bytes_a_ball_is_off_by_a_fraction_of_a_pixel(name: str) -> None:
    board = Board.preset(name)
    for seed in range(tries(20, 100)):
        flight = flight_of(board, seed)
        (path,) = decoder.paths(path_of(seed, 0, 60, flight.trajectory)[0].data)
        assert path["ball"] == seed
        place, angle = errors(board, flight, path["knots"])
        assert place <= ERROR, seed
        assert angle <= paths.TURN_TOLERANCE + 1e-5, seed


@pytest.mark.long
@pytest.mark.parametrize("gravity", [0.3, 1.62, 24.79])
@pytest.mark.parametrize("drag", [0.0, 1e-9, 3.0])
def test_whatever_the_law_a_path_fits(gravity: float, drag: float) -> None:
    form = {**Board.preset("triangle-8").to_dict(), "gravity": gravity, "drag": drag}
    board = Board.from_json(form)
    for seed in range(tries(2, 5)):
        flight = flight_of(board, seed)
        (path,) = decoder.paths(path_of(0, 0, 60, flight.trajectory)[0].data)
        assert errors(board, flight, path["knots"])[0] <= ERROR


def test_a_knot_says_what_the_ball_bounces_off() -> None:
    pegs = walls = 0
    board = Board.preset("classic")
    for seed in range(40):
        record = drop(board, seed)
        hits = {
            float(hit["t"]): int(hit["index"]) + (len(board.pegs) if hit["kind"] else 0)
            for hit in record.impacts
            if hit["kind"] in (KIND_PEG, KIND_WALL)
        }
        (path,) = decoder.paths(path_of(0, 0, 60, flight_of(board, seed).trajectory)[0].data)
        for knot in path["knots"]:
            if knot["hit"] >= 0:
                assert hits[min(hits, key=lambda t: abs(t - knot["t"]))] == knot["hit"]
                pegs += knot["hit"] < len(board.pegs)
                walls += knot["hit"] >= len(board.pegs)
    assert pegs > 200
    assert walls > 3


def test_a_path_begins_and_ends_with_the_drop() -> None:
    board = Board.preset("triangle-16")
    record = drop(board, 7)
    (path,) = decoder.paths(path_of(0, 0, 60, flight_of(board, 7).trajectory)[0].data)
    first, last = path["knots"][0], path["knots"][-1]
    assert (first["t"], first["x"], first["angle"]) == (0.0, np.float32(record.x_start), 0.0)
    assert (last["t"], last["x"]) == (np.float32(record.duration), np.float32(record.x_end))
    assert [first["ax"], first["ay"]] == [0.0, np.float32(board.gravity)]


@pytest.mark.parametrize("name", BOARDS)
def test_a_path_takes_little_more_than_a_quarter_of_the_bytes_of_snapshots(name: str) -> None:
    """With fifty balls, when the headers of snapshots matter least."""
    room = IndependentRoom("r", Board.preset(name), tick_rate=60, max_balls=50)
    whole = sum(len(room.current_path(room.drop(DropCommand(n)).ball)) for n in range(50))
    shown = 0
    while room.awake:
        room.step(watched=True)
        shown += len(room.snapshot())
    assert whole <= 0.28 * shown


# Long paths.


def test_a_long_path_comes_in_parts_before_the_ball_needs_them() -> None:
    board = elastic()
    flight = flight_of(board, 1)
    assert len(flight.trajectory.events) > 6 * MOST_KNOTS
    start, rate = 1000, 60
    parts = path_of(3, start, rate, flight.trajectory)
    knots = [decoder.paths(part.data)[0]["knots"] for part in parts]
    assert max(map(len, knots)) == MOST_KNOTS
    assert len(knots) > 5
    for before, after in pairwise(knots):
        assert before[-1] == after[0]
    whole = knots[0] + [knot for part in knots[1:] for knot in part[1:]]
    times = np.linspace(0.0, flight.duration, SAMPLES)
    true = flight.trajectory.states_at(times)
    for t, state in zip(times.tolist(), true, strict=True):
        x, y, _ = decoder.pose(whole, t, board.drag)
        assert np.hypot(x - state[1], y - state[2]) <= 4 * ERROR, "times are known to 30 us"
    sent, tick = current_parts(parts, start), start
    last = start + flight.ticks(1 / rate)
    while tick < last:
        arrived = {part["ball"]: part["knots"] for part in decoder.paths(sent)}[3]
        assert start + arrived[-1]["t"] * rate >= min(tick + LEAD * rate / 2, last - 1)
        more = due_parts(parts, tick, tick + 60)
        tick += 60
        sent = more or sent


def test_a_late_client_gets_the_part_that_the_ball_is_in() -> None:
    board = elastic()
    parts = path_of(0, 0, 60, flight_of(board, 1).trajectory)
    for tick in range(0, 60_000, 997):
        found = decoder.paths(current_parts(parts, tick))
        assert len(found) <= 2
        assert found[0]["knots"][0]["t"] * 60 <= tick + 1e-3
        assert found[-1]["knots"][-1]["t"] * 60 >= min(tick, 59_990)


def test_further_parts_are_sent_once_by_the_room() -> None:
    room = IndependentRoom("r", elastic(), tick_rate=60, max_balls=2)
    room.drop(DropCommand(1))
    room.drop(DropCommand(2))
    got = decoder.paths(room.first_message("paths") or b"")
    assert [part["ball"] for part in got] == [0, 1]
    before = 0
    for tick in range(100, 60_000, 100):
        room.advance(tick)
        if parts := room.due_paths(before):
            got += decoder.paths(parts)
        before = tick
    begins = [part["knots"][0]["t"] for part in got if part["ball"] == 0]
    assert begins == sorted(set(begins))
    assert len(begins) == len(path_of(0, 0, 60, flight_of(room.board, 1).trajectory))


# Rooms.


def test_nothing_is_cut_while_nobody_needs_it() -> None:
    room = IndependentRoom("r", Board.preset("triangle-12"), tick_rate=60, max_balls=10)
    balls = [room.drop(DropCommand(seed)).ball for seed in range(3)]
    for _ in range(90):
        room.step(watched=True)
    assert room.uncut == balls
    assert room.first_message("snapshots") is None
    assert room.uncut == balls
    shown = decoder.paths(room.first_message("paths") or b"")
    assert [path["ball"] for path in shown] == balls
    assert room.uncut == []
    while room.awake:
        room.step(watched=True)
    assert room._paths == {}
    assert room.first_message("paths") is None


def test_paths_are_known_of_live_balls_of_the_exact_solver_only() -> None:
    world = World(Board.preset("triangle-8"))
    ball = world.add(seed=1)
    assert world.trajectory(ball).end[0] == drop(world.board, 1).duration
    with pytest.raises(ParameterError, match="ball 7 is not in flight"):
        world.trajectory(7)
    stepped = World(Board.preset("triangle-8"), solver="stepped")
    with pytest.raises(ParameterError, match="stepped"):
        stepped.trajectory(stepped.add(seed=1))


async def binary(player: Any) -> bytes:
    while not isinstance(frame := await player.step(), bytes):
        pass
    return frame


async def test_a_hello_is_followed_by_the_flights_in_the_air(server: Running) -> None:
    async with playing(server.socket("triangle-16")) as other:
        await other.send(type="drop", seed=3)
        await other.until("accepted")
        async with playing(server.socket("triangle-16?stream=paths")) as player:
            (path,) = decoder.paths(await binary(player))
            (ball,) = player.hello["balls"]
    assert path["ball"] == ball["ball"]
    assert path["knots"][-1]["t"] == np.float32(drop("triangle-16", 3).duration)


async def test_a_live_client_draws_the_drop_from_one_message(
    server: Running, http: httpx.Client
) -> None:
    board = Board.preset("triangle-8").replace(gravity=50.0)
    room = http.post("/api/v1/rooms", json={"board": board.to_dict()}).json()["id"]
    url = server.socket(room, "?stream=paths")
    async with playing(server.socket(room)) as whole, playing(url) as player:
        hello = player.hello
        assert (hello["stream"], hello["protocol"]) == ("paths", 2)
        await player.send(type="drop", seed=1)
        accepted = await player.until("accepted")
        (path,) = decoder.paths(await binary(player))
        clock = hello
        # More than the one event it received: contacts count, although `paths` omits them.
        while clock["seq"] <= hello["seq"] + 1:
            clock = await player.until("clock")
        landed = await player.until("landed", ball=accepted["ball"])
        assert await whole.until("landed") == landed, "both streams have the same landing"
    assert path["ball"] == accepted["ball"]
    place, _ = errors(board, flight_of(board, 1), path["knots"])
    assert place <= ERROR
    assert landed["t"] == drop(board, 1).duration
    assert len(player.binaries) == 1
    assert len(player.binaries[0]) < sum(map(len, whole.binaries))
    assert set(player.kinds()) <= {"accepted", "landed", "clock"}
    async with playing(url) as again:
        asked = {"run": hello["run"], "key": hello["key"], "since": clock["seq"]}
        await again.send(type="resume", **asked)
        missed = await again.until("missed")
    assert [event["ball"] for event in missed["events"]] == [landed["ball"]]


async def test_balls_that_touch_have_no_paths_only_snapshots(server: Running) -> None:
    async with playing(server.socket("interacting-triangle-8?stream=paths")) as player:
        assert player.hello["stream"] == "snapshots"
        assert (await binary(player))[0] == 0x50


def test_no_stream_means_snapshots_and_a_version_need_not_be_stated() -> None:
    assert client_messages.parse_stream(None) == client_messages.parse_stream("") == "snapshots"
    client_messages.parse_protocol(None)
    client_messages.parse_protocol("2")
    with pytest.raises(InvalidValueError, match="replaces 'segments'"):
        client_messages.parse_protocol("1")
