"""The stream `segments`: a ball drawn from the bytes follows the path of the drop."""

import bisect
import json
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import MalformedError
from app.protocol import client_messages, segments
from app.protocol.messages import Extent
from app.protocol.path import (
    DROPPED,
    OFF_WALL,
    TOLERANCE,
    TURN_TOLERANCE,
    UNDER_WAY,
    Segment,
)
from app.rooms.independent import IndependentRoom
from app.rooms.pending import DropCommand
from engine import Board, ParameterError, World, drop
from engine.constants import KIND_PEG, KIND_WALL
from tests.app.protocol.decoders import decode_segments, pose_at
from tests.kit.player import playing
from tests.kit.serving import Running
from tests.long import tries

GOLDEN = json.loads((Path(__file__).parents[2] / "golden" / "segments.json").read_text())
BOARDS = ("triangle-8", "triangle-12", "triangle-16", "classic", "galton")

PIXEL = 0.01  # m, at 100 pixels a metre
FLIGHTS_OFF = 0.03 * PIXEL  # the largest error by rounding of a flight on a preset
HALF_STEP = 1.0 / (2 * 1024 * 60)  # s, the largest rounding error of a segment's start
BYTES = {"flight": 18, "curve": 26}


def golden_scale() -> segments.Scale:
    given = dict(GOLDEN["scale"])
    return segments.Scale(Extent(**given.pop("extent")), **given)


def as_golden(segment: Segment) -> dict[str, Any]:
    form = msgspec.structs.asdict(segment)
    form["bend"] = list(segment.bend) if segment.bend else None
    return form


@pytest.mark.parametrize("golden", GOLDEN["frames"], ids=lambda golden: golden["name"])
def test_golden_bytes_decode_to_exactly_these_values(golden: dict[str, Any]) -> None:
    message = decode_segments(bytes.fromhex(golden["hex"]), golden_scale())
    assert (message.tick, message.seq) == (golden["tick"], golden["seq"])
    assert message.full == golden["full"]
    assert [as_golden(segment) for segment in message.flights] == golden["flights"]
    assert [as_golden(segment) for segment in message.curves] == golden["curves"]


@pytest.mark.parametrize("golden", GOLDEN["frames"], ids=lambda golden: golden["name"])
def test_golden_segments_are_drawn_here(golden: dict[str, Any]) -> None:
    scale = golden_scale()
    message = decode_segments(bytes.fromhex(golden["hex"]), scale)
    shown = [segment for segment in (*message.flights, *message.curves) for _ in range(2)]
    assert len(shown) == len(golden["drawn"])
    for segment, drawn in zip(shown, golden["drawn"], strict=True):
        pose = pose_at(segment, drawn["at"], **scale.law())
        assert pose == pytest.approx(drawn["pose"], 1e-12)


@given(st.binary(max_size=80))
def test_bytes_that_are_no_segments_are_refused_by_one_error(data: bytes) -> None:
    try:
        message = decode_segments(data, golden_scale())
    except MalformedError:
        return
    shown = BYTES["flight"] * len(message.flights) + BYTES["curve"] * len(message.curves)
    assert len(data) == 16 + shown


@pytest.mark.parametrize(
    "data",
    [
        b"",
        bytes(15),
        bytes.fromhex(GOLDEN["frames"][0]["hex"])[:-1],
        bytes.fromhex(GOLDEN["frames"][0]["hex"]) + b"\0",
        b"\x50" + bytes.fromhex(GOLDEN["frames"][0]["hex"])[1:],
        b"\x53\x01" + bytes.fromhex(GOLDEN["frames"][0]["hex"])[2:],
    ],
    ids=["nothing", "half a header", "a byte short", "a byte too many", "magic", "version"],
)
def test_a_damaged_frame_is_refused(data: bytes) -> None:
    with pytest.raises(MalformedError):
        decode_segments(data, golden_scale())


class Drawing:
    """A client that draws balls from messages; times are seconds since the room's start."""

    def __init__(self, scale: segments.Scale) -> None:
        self.scale = scale
        self.segments: dict[int, list[Segment]] = {}

    def take(self, data: bytes) -> None:
        message = decode_segments(data, self.scale)
        for segment in (*message.flights, *message.curves):
            self.segments.setdefault(segment.ball, []).append(segment)

    def drawn(self, ball: int, times: Any) -> tuple[Any, list[Segment]]:
        """x, y and angle of a ball at each time, and its segment then."""
        shown = sorted(self.segments[ball], key=lambda segment: segment.t)
        starts = [segment.t for segment in shown]
        on = [shown[max(bisect.bisect(starts, t) - 1, 0)] for t in times]
        law = self.scale.law()
        return np.array([pose_at(p, t, **law) for p, t in zip(on, times, strict=True)]), on


def assert_drawn_true(
    drawing: Drawing, ball: int, alone: Any, start: int, since: float = 0.0
) -> float:
    """Compare a drawn ball with the drop; returns the largest tolerance of its flights, m.

    The tolerance is half a step of place, plus half a step of speed times the flight's age; with
    drag k the age is replaced by (1 - exp(-k age)) / k.
    """
    scale = drawing.scale
    times = np.arange(since, alone.duration, 1.0 / 240.0)
    states = alone.states(times)
    drawn, on = drawing.drawn(ball, times + start / scale.tick_rate)
    age = times + start / scale.tick_rate - np.array([segment.t for segment in on])
    curved = np.array([segment.bend is not None for segment in on])
    box = scale.extent
    lasting = age if scale.drag == 0.0 else -np.expm1(-scale.drag * age) / scale.drag
    rounded = 0.25 * scale.velocity_scale * np.where(curved, age, lasting) + 1e-9
    by_place = (box.x_max - box.x_min, 0.5 * (box.y_max - box.y_min))
    may_x, may_y = (rounded + each / segments._GRID for each in by_place)
    # A segment may start half a step of time before or after the bounce.
    begins = np.array(sorted(segment.t for segment in drawing.segments[ball]))
    from_bounce = np.abs(times[:, None] + start / scale.tick_rate - begins).min(axis=1)
    speed = np.hypot(states["vx"], states["vy"])
    common = np.where(from_bounce <= 2.0 * HALF_STEP, 2.0 * speed * HALF_STEP, 0.0)
    common += np.where(curved, TOLERANCE, 0.0)
    assert (np.abs(drawn[:, 0] - states["x"]) <= may_x + common).all()
    assert (np.abs(drawn[:, 1] - states["y"]) <= may_y + common).all()
    off = np.remainder(drawn[:, 2] - states["theta"] + np.pi, 2 * np.pi) - np.pi
    rounding = np.pi / 256 + 0.5001 * scale.spin_scale * age
    rounding += 2.0 * np.abs(states["omega"]) * HALF_STEP
    assert (np.abs(off) <= np.where(curved, TURN_TOLERANCE, 0.0) + rounding).all()
    return float(np.hypot(may_x, may_y)[~curved].max(initial=0.0))


class Played(NamedTuple):
    """A played room: drawing, balls by seed, bytes of segments (cut) and snapshots (whole)."""

    drawing: Drawing
    balls: dict[int, int]
    cut: int
    whole: int


def drawn_room(board: Board, seeds: range) -> Played:
    room = IndependentRoom("r", board, tick_rate=60, max_balls=len(seeds))
    room.watch_segments(True)
    drawing = Drawing(room.scale)
    balls = {}
    cut, whole = 0, 0
    for seed in seeds:
        balls[seed] = room.drop(DropCommand(seed)).ball
    while room.awake:
        room.step(watched=True)
        whole += len(room.snapshot())
        message = room.segments()
        if message is not None:
            cut += len(message)
            drawing.take(message)
    return Played(drawing, balls, cut, whole)


@pytest.mark.parametrize("name", BOARDS)
def test_drawn_from_the_bytes_a_ball_is_off_by_part_of_a_pixel(name: str) -> None:
    board = Board.preset(name)
    played = drawn_room(board, range(20))
    for seed, ball in played.balls.items():
        assert assert_drawn_true(played.drawing, ball, drop(board, seed), 0) <= FLIGHTS_OFF


@pytest.mark.long  # with more balls the messages' headers matter less
@pytest.mark.parametrize("name", BOARDS)
@pytest.mark.parametrize("balls", tries([50], [50, 200]))
def test_segments_are_a_fifth_of_the_bytes_of_snapshots_or_less(name: str, balls: int) -> None:
    """One segment a bounce instead of one snapshot a tick; short flights save less."""
    played = drawn_room(Board.preset(name), range(balls))
    assert played.cut <= played.whole / 5


@pytest.mark.parametrize("name", BOARDS)
def test_balls_that_fall_alone_take_a_fifth_of_the_bytes_too(name: str) -> None:
    """Headers dominate both streams; a ball that hops for long may take up to a third."""
    alone = [drawn_room(Board.preset(name), range(seed, seed + 1)) for seed in range(10)]
    assert sum(each.cut for each in alone) <= sum(each.whole for each in alone) / 5
    assert max(each.cut / each.whole for each in alone) <= 1 / 3


@pytest.mark.long
@pytest.mark.parametrize("gravity", [0.3, 1.62, 24.79])
@pytest.mark.parametrize("drag", [0.0, 3.0])
def test_whatever_the_law_the_segments_fit(gravity: float, drag: float) -> None:
    form = {**Board.preset("triangle-8").to_dict(), "gravity": gravity, "drag": drag}
    board = Board.from_json(form)
    played = drawn_room(board, range(tries(2, 5)))
    for seed, ball in played.balls.items():
        assert_drawn_true(played.drawing, ball, drop(board, seed), 0)


def test_a_flight_says_what_it_bounced_off() -> None:
    board = Board.preset("triangle-8")
    played = drawn_room(board, range(20))
    compared = 0
    for seed, ball in played.balls.items():
        hits = [
            (float(impact["t"]), int(impact["kind"]), int(impact["index"]))
            for impact in drop(board, seed).impacts
            if impact["kind"] in (KIND_PEG, KIND_WALL)
        ]
        for segment in played.drawing.segments[ball]:
            if segment.bend is None and segment.kind in (KIND_PEG, KIND_WALL):
                _, kind, index = min(hits, key=lambda hit: abs(hit[0] - segment.t))
                assert (kind, index) == (segment.kind, segment.index)
                compared += 1
        assert played.drawing.segments[ball][0].kind == DROPPED
    assert compared > 100


def test_a_late_client_gets_current_segments_and_then_the_rest() -> None:
    board = Board.preset("triangle-12")
    room = IndependentRoom("r", board, tick_rate=60, max_balls=10)
    balls = [room.drop(DropCommand(seed)).ball for seed in range(3)]
    for _ in range(90):
        room.step(watched=True)
    drawing = Drawing(room.scale)
    full = decode_segments(room.keyframe(), room.scale)
    assert full.full
    assert sorted(segment.ball for segment in (*full.flights, *full.curves)) == balls
    drawing.take(room.keyframe())
    while room.awake:
        room.step(watched=True)
        message = room.segments()
        if message is not None:
            assert not decode_segments(message, room.scale).full
            drawing.take(message)
    for seed, ball in enumerate(balls):
        assert_drawn_true(drawing, ball, drop(board, seed), 0, since=90 / 60)
    assert len(decode_segments(room.keyframe(), room.scale).flights) == 0


def test_a_segment_repeated_in_a_full_frame_is_the_same() -> None:
    room = IndependentRoom("r", Board.preset("triangle-8"), tick_rate=60, max_balls=10)
    room.watch_segments(True)
    room.drop(DropCommand(5))
    known: set[Segment] = set()
    compared = 0
    while room.awake:
        room.step(watched=True)
        data = room.segments()
        if data is not None:
            message = decode_segments(data, room.scale)
            known.update((*message.flights, *message.curves))
        again = decode_segments(room.keyframe(), room.scale)
        for segment in (*again.flights, *again.curves):
            assert segment in known
            compared += 1
    assert compared > 100


def test_a_long_flight_starts_where_the_ball_was_a_second_ago() -> None:
    form = {**Board.preset("triangle-8").to_dict(), "gravity": 0.05, "drag": 0.2}
    board = Board.from_json(form)
    room = IndependentRoom("r", board, tick_rate=60, max_balls=1)
    ball = room.drop(DropCommand(5)).ball
    first = drop(board, 5).impacts[0]["t"]
    while room.world.tick / 60 < first - 1 / 60:
        room.step(watched=True)
    drawing = Drawing(room.scale)
    drawing.take(room.keyframe())
    (segment,) = drawing.segments[ball]
    assert segment.kind == UNDER_WAY
    assert room.world.tick / 60 - segment.t == 63 / 60
    times = np.linspace(segment.t, first, 50)
    drawn, _ = drawing.drawn(ball, times)
    states = drop(board, 5).states(times)
    assert np.abs(drawn[:, 0] - states["x"]).max() < FLIGHTS_OFF
    assert np.abs(drawn[:, 1] - states["y"]).max() < FLIGHTS_OFF


@pytest.mark.parametrize(("x", "kept"), [(-6.0, -6.0), (-20.0, -8.0), (9.0, 8.0)])
def test_a_ball_is_sent_up_to_half_a_board_outside(x: float, kept: float) -> None:
    scale = segments.Scale(Extent(-4.0, 4.0, 0.0, 6.0), 1 / 1024, 1 / 64, 60, 9.81, 0.0)
    segment = Segment(1, OFF_WALL, 3, 0.5, x, 2.0, -1.0, 0.0, 0.0, 0.0)
    stream = segments.SegmentStream(scale, 0)
    data = segments._message(31, 0, [segments._Due(30, 30.0, segment)], 0, scale)
    assert stream.take(1, 0) is None
    assert decode_segments(data, scale).flights[0].x == pytest.approx(kept, abs=2e-4)


def test_segments_come_with_the_tick_in_which_they_begin() -> None:
    room = IndependentRoom("r", Board.preset("triangle-8"), tick_rate=60, max_balls=10)
    room.watch_segments(True)
    start = room.drop(DropCommand(5)).tick
    while room.awake:
        room.step(watched=True)
        data = room.segments()
        if data is None:
            continue
        message = decode_segments(data, room.scale)
        for segment in (*message.flights, *message.curves):
            age = message.tick - segment.t * 60
            assert 0.0 <= age + 1e-9 < 1.0 + 1e-9 or segment.t * 60 == start


def test_paths_are_known_of_live_balls_of_the_exact_solver_only() -> None:
    world = World(Board.preset("triangle-8"))
    ball = world.add(seed=1)
    assert world.trajectory(ball).end[0] == drop(world.board, 1).duration
    with pytest.raises(ParameterError, match="ball 7 is not in flight"):
        world.trajectory(7)
    stepped = World(Board.preset("triangle-8"), solver="stepped")
    with pytest.raises(ParameterError, match="stepped"):
        stepped.trajectory(stepped.add(seed=1))


def scale_of(hello: dict[str, Any]) -> segments.Scale:
    board = hello["board"]
    return segments.Scale(
        Extent(**hello["extent"]),
        hello["velocity_scale"],
        hello["spin_scale"],
        hello["tick_rate"],
        board["gravity"],
        board["drag"],
    )


async def test_a_live_client_draws_the_drop(server: Running) -> None:
    async with playing(server.socket("triangle-8?stream=segments")) as player:
        hello = player.hello
        assert (hello["stream"], hello["spin_scale"]) == (
            "segments",
            hello["velocity_scale"] / hello["board"]["ball"]["radius"],
        )
        drawing = Drawing(scale_of(hello))
        await player.send(type="drop", seed=42)
        accepted = await player.until("accepted")
        await player.until("landed", ball=accepted["ball"])
    for data in player.binaries:
        drawing.take(data)
    alone = drop(Board.preset("triangle-8"), 42)
    assert_drawn_true(drawing, accepted["ball"] & 0xFFFF, alone, accepted["tick"])
    assert "contact" not in player.kinds()
    assert decode_segments(player.binaries[0], drawing.scale).full


async def test_both_streams_of_a_room_have_the_same_landing(server: Running) -> None:
    async with (
        playing(server.socket("triangle-8")) as whole,
        playing(server.socket("triangle-8?stream=segments")) as cut,
    ):
        await whole.send(type="drop", seed=3)
        landings = [await each.until("landed", seed="3") for each in (whole, cut)]
    assert landings[0] == landings[1]
    assert sum(map(len, cut.binaries)) < sum(map(len, whole.binaries))


async def test_segments_are_stamped_with_the_events_so_far(server: Running) -> None:
    async with (
        playing(server.socket("triangle-8")),  # its client receives contacts
        playing(server.socket("triangle-8?stream=segments")) as player,
    ):
        scale = scale_of(player.hello)
        await player.send(type="drop", seed=3)
        landed = await player.until("landed", seed="3")
        seen = [decode_segments(data, scale).seq for data in player.binaries]
        assert seen == sorted(seen)
        assert seen[0] == player.hello["seq"]
        # More than the one event it received: contacts count, although `segments` omits them.
        assert seen[-1] > player.hello["seq"] + 1
        hello = player.hello
        asked = {"run": hello["run"], "key": hello["key"], "since": seen[-1]}
    async with playing(server.socket("triangle-8?stream=segments")) as again:
        await again.send(type="resume", **asked)
        missed = await again.until("missed")
    assert [event["ball"] for event in missed["events"]] == [landed["ball"]]


async def test_an_unknown_stream_is_named(server: Running) -> None:
    async with playing(server.socket("main?stream=video")) as player:
        assert (player.hello["type"], player.hello["code"]) == ("error", "invalid-value")
        assert "'video' is not one of: snapshots, segments" in player.hello["detail"]


def test_no_stream_means_snapshots() -> None:
    assert client_messages.parse_stream(None) == client_messages.parse_stream("") == "snapshots"
