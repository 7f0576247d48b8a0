"""Paths in pieces: drawn from the bytes alone, a ball is where the drop says it is."""

import bisect
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app import protocol, segments
from app.errors import MalformedError
from app.room import DropCommand, Room
from engine import Board, ParameterError, World, drop
from engine.constants import KIND_PEG, KIND_WALL
from tests.app.conftest import Running, playing

GOLDEN = json.loads((Path(__file__).parent.parent / "golden" / "segments.json").read_text())
LAW = GOLDEN["law"]
BOARDS = ("triangle-8", "triangle-12", "triangle-16", "classic", "galton")

FLOAT32 = 2e-6  # m; rounding of places, speeds and times to 32 bits


def rows(array: Any) -> list[dict[str, Any]]:
    return [dict(zip(array.dtype.names, row, strict=True)) for row in array.tolist()]


@pytest.mark.parametrize("golden", GOLDEN["frames"], ids=lambda golden: golden["name"])
def test_golden_bytes_decode_to_exactly_these_values(golden: dict[str, Any]) -> None:
    frame = segments.decode_segments(bytes.fromhex(golden["hex"]))
    assert (frame.tick, frame.full) == (golden["tick"], golden["full"])
    assert rows(frame.flights) == golden["flights"]
    assert rows(frame.curves) == golden["curves"]


@pytest.mark.parametrize("golden", GOLDEN["frames"], ids=lambda golden: golden["name"])
def test_golden_pieces_are_drawn_here(golden: dict[str, Any]) -> None:
    frame = segments.decode_segments(bytes.fromhex(golden["hex"]))
    pieces = [piece for piece in (*frame.flights, *frame.curves) for _ in range(2)]
    assert len(pieces) == len(golden["drawn"])
    for piece, drawn in zip(pieces, golden["drawn"], strict=True):
        assert segments.pose_at(piece, drawn["at"], **LAW) == pytest.approx(drawn["pose"], 1e-12)


@given(st.binary(max_size=80))
def test_bytes_that_are_no_segments_are_refused_and_nothing_else_is_raised(data: bytes) -> None:
    try:
        frame = segments.decode_segments(data)
    except MalformedError:
        return
    assert len(data) == 12 + 28 * len(frame.flights) + 36 * len(frame.curves)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        bytes(11),
        bytes.fromhex(GOLDEN["frames"][0]["hex"])[:-1],
        bytes.fromhex(GOLDEN["frames"][0]["hex"]) + b"\0",
        b"\x50" + bytes.fromhex(GOLDEN["frames"][0]["hex"])[1:],
        b"\x53\x02" + bytes.fromhex(GOLDEN["frames"][0]["hex"])[2:],
    ],
    ids=["nothing", "half a header", "a byte short", "a byte too many", "magic", "version"],
)
def test_a_damaged_frame_is_refused(data: bytes) -> None:
    with pytest.raises(MalformedError):
        segments.decode_segments(data)


class Drawing:
    """A client that draws balls from frames alone."""

    def __init__(self, board: Board, spin_scale: float) -> None:
        self.law = {"gravity": board.gravity, "drag": board.drag, "spin_scale": spin_scale}
        self.pieces: dict[int, list[np.void]] = {}

    def take(self, data: bytes) -> None:
        frame = segments.decode_segments(data)
        for piece in (*frame.flights, *frame.curves):
            self.pieces.setdefault(int(piece["id"]), []).append(piece)

    def poses(self, ball: int, times: Any) -> Any:
        """x, y and angle at each of the times, and how long ago its piece began."""
        pieces = sorted(self.pieces[ball], key=lambda piece: float(piece["t"]))
        starts = [float(piece["t"]) for piece in pieces]
        rows = [bisect.bisect(starts, t + 1e-6) - 1 for t in times]
        poses = [
            segments.pose_at(pieces[k], t, **self.law) for k, t in zip(rows, times, strict=True)
        ]
        return np.array(poses), times - np.array(starts)[rows]


def assert_drawn_true(drawing: Drawing, ball: int, alone: Any, since: float = 0.0) -> None:
    times = np.arange(since, alone.duration, 1.0 / 240.0)
    states = alone.states(times)
    drawn, age = drawing.poses(ball, times)
    allowed = segments.TOLERANCE + FLOAT32
    assert np.abs(drawn[:, 0] - states["x"]).max() <= allowed
    assert np.abs(drawn[:, 1] - states["y"]).max() <= allowed
    off = np.remainder(drawn[:, 2] - states["theta"] + np.pi, 2 * np.pi) - np.pi
    rounding = np.pi / 256 + 0.5001 * drawing.law["spin_scale"] * age
    assert (np.abs(off) <= segments.TURN_TOLERANCE + rounding).all()


def drawn_room(board: Board, seeds: range) -> tuple[Drawing, dict[int, int], int, int]:
    """Play seeds in a room watched both ways: the drawing, ball by seed, bytes of each stream."""
    room = Room("r", board, tick_rate=60, max_balls=len(seeds))
    room.watch_segments(True)
    drawing = Drawing(board, room.spin_scale)
    balls = {}
    cut, whole = 0, 0
    for seed in seeds:
        balls[seed] = room.drop(DropCommand(seed)).ball
    while room.awake:
        room.step(watched=True)
        whole += len(room.frame())
        frame = room.segments()
        if frame is not None:
            cut += len(frame)
            drawing.take(frame)
    return drawing, balls, cut, whole


@pytest.mark.parametrize("name", BOARDS)
def test_drawn_from_the_bytes_alone_every_ball_is_where_its_drop_says(name: str) -> None:
    board = Board.preset(name)
    drawing, balls, _, _ = drawn_room(board, range(20))
    for seed, ball in balls.items():
        assert_drawn_true(drawing, ball, drop(board, seed))


@pytest.mark.parametrize("name", BOARDS)
def test_pieces_are_a_quarter_of_the_bytes_of_snapshots_or_less(name: str) -> None:
    """A piece a bounce against a snapshot a tick: the shorter the flights, the less is gained."""
    _, _, cut, whole = drawn_room(Board.preset(name), range(200))
    assert cut <= whole / 4
    _, _, cut, whole = drawn_room(Board.preset(name), range(1))
    assert cut <= whole / 4


@pytest.mark.parametrize("gravity", [0.3, 1.62, 24.79])
@pytest.mark.parametrize("drag", [0.0, 3.0])
def test_whatever_the_law_the_pieces_fit(gravity: float, drag: float) -> None:
    form = {**Board.preset("triangle-8").to_dict(), "gravity": gravity, "drag": drag}
    board = Board.from_json(form)
    drawing, balls, _, _ = drawn_room(board, range(5))
    for seed, ball in balls.items():
        assert_drawn_true(drawing, ball, drop(board, seed))


def test_a_flight_says_what_it_bounced_off() -> None:
    board = Board.preset("triangle-8")
    drawing, balls, _, _ = drawn_room(board, range(20))
    compared = 0
    for seed, ball in balls.items():
        hits = {
            np.float32(impact["t"]): (int(impact["kind"]), int(impact["index"]))
            for impact in drop(board, seed).impacts
            if impact["kind"] in (KIND_PEG, KIND_WALL)
        }
        for piece in drawing.pieces[ball]:
            if "ax" not in (piece.dtype.names or ()) and piece["kind"] in (KIND_PEG, KIND_WALL):
                assert hits[piece["t"]] == (piece["kind"], piece["index"])
                compared += 1
        assert drawing.pieces[ball][0]["kind"] == segments.DROPPED
    assert compared > 100


def test_one_who_comes_late_gets_the_pieces_in_use_and_then_the_rest() -> None:
    board = Board.preset("triangle-12")
    room = Room("r", board, tick_rate=60, max_balls=10)
    balls = [room.drop(DropCommand(seed)).ball for seed in range(3)]
    for _ in range(90):
        room.step(watched=True)
    drawing = Drawing(board, room.spin_scale)
    full = segments.decode_segments(room.all_segments())
    assert full.full
    assert sorted(piece["id"] for piece in (*full.flights, *full.curves)) == balls
    drawing.take(room.all_segments())
    while room.awake:
        room.step(watched=True)
        frame = room.segments()
        if frame is not None:
            assert not segments.decode_segments(frame).full
            drawing.take(frame)
    for seed, ball in enumerate(balls):
        assert_drawn_true(drawing, ball, drop(board, seed), since=90 / 60)
    assert len(segments.decode_segments(room.all_segments()).flights) == 0


def test_pieces_come_with_the_tick_in_which_they_begin() -> None:
    room = Room("r", Board.preset("triangle-8"), tick_rate=60, max_balls=10)
    room.watch_segments(True)
    start = room.drop(DropCommand(5)).tick
    while room.awake:
        room.step(watched=True)
        data = room.segments()
        if data is None:
            continue
        frame = segments.decode_segments(data)
        for piece in (*frame.flights, *frame.curves):
            age = frame.tick - start - float(piece["t"]) * 60
            assert 0.0 <= age + 1e-4 < 1.0 + 1e-4 or piece["t"] == 0.0


def test_paths_are_known_of_live_balls_of_the_exact_solver_only() -> None:
    world = World(Board.preset("triangle-8"))
    ball = world.add(seed=1)
    assert world.trajectory(ball).end[0] == drop(world.board, 1).duration
    with pytest.raises(ParameterError, match="ball 7 is not in flight"):
        world.trajectory(7)
    stepped = World(Board.preset("triangle-8"), solver="stepped")
    with pytest.raises(ParameterError, match="stepped"):
        stepped.trajectory(stepped.add(seed=1))


async def test_a_live_client_draws_the_drop(server: Running) -> None:
    async with playing(server.socket("triangle-8?stream=segments")) as player:
        hello = player.hello
        assert (hello["stream"], hello["spin_scale"]) == (
            "segments",
            hello["velocity_scale"] / hello["board"]["ball"]["radius"],
        )
        drawing = Drawing(Board.preset("triangle-8"), hello["spin_scale"])
        await player.send(type="drop", seed=42)
        accepted = await player.until("accepted")
        await player.until("landed", ball=accepted["ball"])
    for data in player.binaries:
        drawing.take(data)
    assert_drawn_true(drawing, accepted["ball"] & 0xFFFF, drop(Board.preset("triangle-8"), 42))
    assert "contact" not in player.kinds()
    assert segments.decode_segments(player.binaries[0]).full


async def test_both_streams_of_a_room_tell_of_the_same_landing(server: Running) -> None:
    async with (
        playing(server.socket("triangle-8")) as whole,
        playing(server.socket("triangle-8?stream=segments")) as cut,
    ):
        await whole.send(type="drop", seed=3)
        landings = [await each.until("landed", seed="3") for each in (whole, cut)]
    assert landings[0] == landings[1]
    assert sum(map(len, cut.binaries)) < sum(map(len, whole.binaries)) / 3


async def test_an_unknown_stream_is_named(server: Running) -> None:
    async with playing(server.socket("main?stream=video")) as player:
        assert (player.hello["type"], player.hello["code"]) == ("error", "invalid-value")
        assert "'video' is not one of: snapshots, segments" in player.hello["detail"]


def test_no_stream_means_snapshots() -> None:
    assert protocol.parse_stream(None) == protocol.parse_stream("") == "snapshots"
