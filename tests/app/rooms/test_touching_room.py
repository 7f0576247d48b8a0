"""A room of touching balls without a server: equal inputs give equal events and frames."""

import random
import threading
from typing import Any

import msgspec
import pytest

from plinko.app.errors import BallLimitError, InvalidValueError, MissingBallError
from plinko.app.protocol import client_messages, messages
from plinko.app.protocol.touching_messages import AddMessage, Change
from plinko.app.rooms import log as roomlog
from plinko.app.rooms.pending import DropCommand, PendingInput
from plinko.app.rooms.records import InputRow
from plinko.app.rooms.touching.checks import MOST_OVERLAPS
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import Scene, as_kept
from plinko.app.rooms.touching.values import BALL, MOST_WORK, SETTINGS
from plinko.engine import Board, RecordError
from plinko.engine.errors import PlinkoError
from tests.app.protocol.decoders import decode_snapshot
from tests.app.rooms.logs import row_of

TICKS = 60
BOARD = Board.preset("triangle-8")


def scene(**values: Any) -> Scene:
    return Scene.of({"scene": "sandbox", "balls": 0, **values}, tick_rate=TICKS, max_balls=500)


def box(most: int = 500, **values: Any) -> TouchingRoom:
    return TouchingRoom("box", scene(**values), tick_rate=TICKS, max_balls=most)


def table() -> TouchingRoom:
    return TouchingRoom("table", BOARD, tick_rate=TICKS, max_balls=100)


def tell(room: TouchingRoom, kind: str, **values: Any) -> list[messages.Event]:
    room.plan_change(change(kind, **values)).durable = True
    return room.enter()[-1].events


def change(kind: str, **values: Any) -> Change:
    message: Change = msgspec.convert({"type": kind, **values}, Change)
    return message


def run(room: TouchingRoom, ticks: int) -> list[messages.Event]:
    events: list[messages.Event] = []
    for _ in range(ticks):
        events += room.step(watched=True)
    return events


def places(room: TouchingRoom) -> dict[int, tuple[float, float]]:
    return {int(b["id"]): (float(b["x"]), float(b["y"])) for b in room.world.bodies}


def test_a_thrown_ball_flies_falls_and_stays_in_the_box_asleep() -> None:
    room = box(restitution=0.3)
    (placed,) = tell(room, "add", x=-2.0, y=1.0, vx=4.0, vy=-3.0, radius=0.2)
    assert isinstance(placed, messages.Placed)
    assert (placed.radius, placed.restitution) == (0.2, 0.3)
    room.step(watched=True)
    ((x, y),) = places(room).values()
    assert x == pytest.approx(-2.0 + 4.0 / TICKS, abs=1e-3)
    assert y < 1.0, "thrown upwards, it rises"
    for _ in range(60 * TICKS):
        if not room.awake:
            break
        room.step(watched=False)
    assert not room.awake, "a ball on the floor falls asleep, and the room with it"
    ((x, y),) = places(room).values()
    assert y == pytest.approx(4.0 - 0.2, abs=0.01)
    asleep = decode_snapshot(room.snapshot(), room.extent, room.velocity_scale).balls
    assert asleep["asleep"].all()


def test_a_held_ball_follows_the_hand_and_flies_on_when_let_go() -> None:
    room = box(gravity=9.81)
    tell(room, "add", x=-2.0, y=2.0, radius=0.1)
    for step in range(60):
        tell(room, "drag", ball=0, x=-2.0 + 0.05 * step, y=2.0)
        run(room, 1)
    (x, y) = places(room)[0]
    assert x == pytest.approx(0.95, abs=0.35)
    assert y == pytest.approx(2.0, abs=0.05), "the hand carries it against gravity"
    tell(room, "release", ball=0)
    run(room, 6)
    assert places(room)[0][0] > x + 0.2, "it flies on as fast as it was led"


def test_a_ball_in_a_hand_is_not_asleep_and_a_silent_hand_releases_it() -> None:
    room = box()
    tell(room, "add", x=0.0, y=1.0)
    tell(room, "drag", ball=0, x=0.0, y=1.0)
    run(room, 4 * TICKS)
    assert places(room)[0][1] == pytest.approx(1.0, abs=0.05)
    run(room, 3 * TICKS)
    assert places(room)[0][1] > 3.0
    room = box(gravity=0.0)
    tell(room, "add", x=0.0, y=1.0)
    tell(room, "drag", ball=0, x=0.0, y=1.0)
    for _ in range(2 * TICKS):
        run(room, 1)
        (ball,) = decode_snapshot(room.snapshot(), room.extent, room.velocity_scale).balls
        assert not ball["asleep"]
    tell(room, "release", ball=0)
    run(room, TICKS)
    (ball,) = decode_snapshot(room.snapshot(), room.extent, room.velocity_scale).balls
    assert ball["asleep"]


def test_settings_and_edits_are_sent_and_take_effect() -> None:
    room = box(balls=3)
    edited, told = tell(room, "settings", gravity="Moon", restitution="Glass on glass")
    assert isinstance(edited, messages.Edited)
    assert isinstance(told, messages.RoomSettings)
    assert edited.ball is None
    assert told.settings["gravity"] == 1.62
    assert told.settings["restitution"] == edited.restitution
    assert room.world.arena.ball(1)["restitution"] == edited.restitution
    tell(room, "edit", ball=1, radius=0.3, density=20.0)
    assert room.world.arena.ball(1)["radius"] == 0.3
    assert room.world.arena.ball(1)["density"] == pytest.approx(20.0)
    (placed,) = tell(room, "add", x=0.0, y=0.5)
    assert isinstance(placed, messages.Placed)
    assert placed.restitution == edited.restitution, "new balls are as the sliders say"
    # One slider sets the material of every pair.
    for room in (box(balls=3), table()):
        tell(room, "settings", restitution=0.05, friction=0.7)
        place = room.world.place
        assert place.wall_material.friction == place.peg_material.friction == 0.7
        # A pair has the greater of its two. The box has no pegs.
        assert place.wall_material.restitution <= 0.05
        assert place.peg_material.restitution <= 0.05 or not place.pegs


def test_each_setting_has_a_range_takes_effect_and_is_sent() -> None:
    for values in (BALL, SETTINGS):
        for name, entry in values.items():
            assert entry.default is not None
            assert entry.low <= entry.default <= entry.high, name
    asked: dict[str, Any] = {
        "gravity": -3.0, "gravity_x": 4.0, "drag": 0.1, "damping": 0.99, "rolling": 0.01,
        "max_speed": 5.0, "correction": 0.5, "dt": 0.01, "substeps": 2, "projection": 0,
        "cell": 0.5,
    }  # fmt: skip
    assert asked.keys() == SETTINGS.keys()
    usual: dict[str, Any] = {name: entry.default for name, entry in SETTINGS.items()}
    room = box(balls=3)
    for wanted in (asked, usual):
        (told,) = tell(room, "settings", **wanted)
        assert isinstance(told, messages.RoomSettings)
        sent: dict[str, Any] = {name: told.settings[name] for name in asked}
        assert sent == wanted
        assert box(balls=3, **sent).world.arena.settings == room.world.arena.settings
    assert room.world.arena.settings == box(balls=3).world.arena.settings


def test_a_scene_of_1_0_0_keeps_its_digest_and_can_be_read() -> None:
    old = Scene.of("sandbox", tick_rate=TICKS, max_balls=500)
    assert old.digest == "04c2af3f85299570e102574aa8ea70f5c083b196544bcfcd40db451b985a6983"
    assert as_kept(old.to_dict()) == old.to_dict()
    assert not {"gravity_x", "rolling", "max_speed", "projection", "cell"} & old.values.keys()
    new = Scene.of({"scene": "sandbox", "rolling": 0.5}, tick_rate=TICKS, max_balls=500)
    assert as_kept(new.to_dict()) == new.to_dict()
    assert new.digest != old.digest


def test_a_reset_begins_another_scene_and_a_cleared_box_is_restored() -> None:
    room = box(balls=5)
    run(room, 30)
    tell(room, "reset", scene={"scene": "sandbox", "balls": 7, "width": 3.0})
    assert (room.world.count, room.world.tick) == (7, 30), "the clock goes on"
    assert room.extent.x_max == 1.5
    tell(room, "clear")
    assert room.world.count == 0
    again = box()
    again.restore(room.checkpoint())
    assert (again.world.count, again.world.digest) == (0, room.world.digest)


def test_drops_on_a_board_knock_each_other_and_land_in_bins() -> None:
    room = table()
    for seed in range(12):
        room.drop(DropCommand(seed))
        run(room, 3)
    events: list[messages.Event] = []
    while room.awake:
        events += room.step(watched=True)
    landed = [event for event in events if isinstance(event, messages.Landed)]
    assert sorted(event.ball for event in landed) == list(range(12))
    assert all(event.digest is None for event in landed)
    assert room.stats().drops == 12
    assert sum(room.stats().histogram) + room.stats().unsettled == 12
    contacts = [event for event in events if isinstance(event, messages.Contact)]
    assert {0, 1, 6} >= {event.kind for event in contacts} >= {0}
    assert room.balls == []


def play(  # noqa: PLR0912 - one branch for each thing that people do
    room: TouchingRoom, seed: int, ticks: int = 240
) -> list[InputRow]:
    """Do everything that players can do, at random; returns the inputs as the ledger's rows."""
    chance = random.Random(seed)
    kept = []

    def keep(pending: PendingInput[Any]) -> None:
        pending.durable = True
        room.enter()
        kept.append(row_of(room, pending))

    def put(kind: str, **values: Any) -> None:
        keep(room.plan_change(change(kind, **values)))

    on_board = room.mode == "interacting"
    for _ in range(ticks):
        balls = list(places(room))
        roll = chance.random()
        x, y = chance.uniform(-0.5, 0.5), chance.uniform(0.5, 1.5)
        if on_board and roll < 0.1:
            keep(room.plan_drop(DropCommand(chance.randrange(1000))))
        elif roll < 0.15:
            put("add", x=x, y=y, vx=chance.uniform(-9, 9), omega=3.0, radius=0.06)
        elif balls and roll < 0.25:
            put("kick", ball=chance.choice(balls), vx=1.0, vy=-2.0)
        elif balls and roll < 0.5:
            put("drag", ball=balls[0], x=x, y=y)
        elif balls and roll < 0.55:
            put("release", ball=balls[0])
        elif balls and roll < 0.58:
            put("remove", ball=balls[-1])
        elif balls and roll < 0.62:
            put("edit", ball=balls[-1], density=10.0, restitution=0.2)
        elif roll < 0.65:
            put("settings", gravity=chance.choice(["Moon", "Jupiter"]), friction=0.4, substeps=6)
        elif roll < 0.67 and not room.paused:
            put("pause", paused=True)
            put("step")
        elif room.paused and roll < 0.75:
            put("pause", paused=False)
        elif roll > 0.99 and not on_board:
            put("reset", scene={"scene": "sandbox", "balls": 4, "seed": "9"})
        if room.awake:
            room.step(watched=True)
    return kept


@pytest.mark.parametrize("kind", ["box", "table"])
def test_the_log_of_a_room_replays_to_the_same_world(kind: str) -> None:
    room = box(balls=8, dt=1 / 90) if kind == "box" else table()
    rows = play(room, seed=5, ticks=600)
    assert len({client_messages.peek(row.data, "type") for row in rows}) >= 9
    log = whole_log(room, rows)
    verdict = roomlog.verify_log(log)
    assert verdict.ok, verdict


def whole_log(room: TouchingRoom, rows: list[InputRow]) -> dict[str, Any]:
    log = roomlog.head(room)
    log["inputs"] = [room.format.entry(row, None, room.world.tick) for row in rows]
    digest = roomlog.LogDigest(roomlog.head(room))
    digest.add(log["inputs"])
    return {**log, "digest": digest.hex()}


@pytest.mark.parametrize("kind", ["box", "table"])
def test_a_room_restored_from_a_checkpoint_goes_on_bit_for_bit(kind: str) -> None:
    # A dt that does not divide the tick leaves a remainder, which the checkpoint must have.
    room = box(balls=8, dt=0.013) if kind == "box" else table()
    if kind == "table":
        for seed in range(9):
            room.drop(DropCommand(seed))
    tell(room, "add", x=0.1, y=0.5, vx=3.0)
    tell(room, "drag", ball=0, x=0.0, y=1.0)
    run(room, 50)
    again = box() if kind == "box" else table()
    again.restore(room.checkpoint())
    for _ in range(100):
        assert again.step(watched=True) == room.step(watched=True)
    assert again.world.digest == room.world.digest
    assert again.checkpoint() == room.checkpoint()
    with pytest.raises(RecordError, match="checkpoint"):
        again.restore(b"nonsense")


@pytest.mark.parametrize("preset", ["triangle-8", "classic", "galton"])
def test_a_room_whose_balls_have_all_gone_is_restored(preset: str) -> None:
    def empty() -> TouchingRoom:
        return TouchingRoom("table", Board.preset(preset), tick_rate=TICKS, max_balls=100)

    first = empty()
    first.drop(DropCommand(1))
    while first.awake:
        first.step(watched=False)
    assert first.world.count == 0
    again = empty()
    again.restore(first.checkpoint())
    assert again.world.digest == first.world.digest
    for room in (first, again):
        room.drop(DropCommand(2))
        run(room, 100)
    assert again.world.digest == first.world.digest


BOX: dict[str, Any] = {"scene": "sandbox"}


def test_frames_and_watching_do_not_change_what_happens() -> None:
    seen, unseen = box(balls=30), box(balls=30)
    for _ in range(120):
        seen.step(watched=True)
        seen.snapshot()
        seen.diagnostics()
        unseen.step(watched=False)
    assert seen.world.digest == unseen.world.digest


@pytest.mark.parametrize(
    ("kind", "values", "says"),
    [
        ("add", {"x": 9.0, "y": 1.0}, "x 9.0 is not from"),
        ("add", {"x": 0.0, "y": -1.0}, "y -1.0 is not from"),
        ("add", {"x": 0.0, "y": None}, "y is missing"),
        ("add", {"x": "left", "y": 1.0}, "x 'left' is not a number"),
        ("add", {"x": 0.0, "y": 1.0, "radius": 0.001}, "radius 0.001 is not from 0.01 to 0.5 m"),
        ("add", {"x": 0.0, "y": 1.0, "vx": 1e9}, "vx 1000000000.0 is not from -100 to 100 m/s"),
        ("kick", {"ball": 0, "vx": float("nan")}, "vx nan is not a finite number"),
        ("edit", {"ball": 0}, "sets none of: radius"),
        ("edit", {"ball": 0, "restitution": 1.5}, "restitution 1.5 is not from 0 to 1"),
        ("settings", {"gravity": "Venus"}, "gravity 'Venus' is neither a number nor one of: Earth"),
        ("settings", {"damping": 0.5}, "damping 0.5 is not from 0.9 to 1"),
        ("settings", {"correction": 1.0}, "correction 1.0 is not from 0.4 to 0.8"),
        ("settings", {"substeps": 2.5}, "substeps 2.5 is not a whole number"),
        ("settings", {"dt": 0.5}, "dt 0.5 is not from 0.001 to 0.1 s"),
        ("reset", {"scene": {"scene": "moon"}}, "scene 'moon' is not one of: sandbox, galton"),
        ("reset", {"scene": BOX | {"ballz": 3}}, "has no 'ballz'; it has: balls"),
        ("reset", {"scene": BOX | {"radii": [0.3, 0.1]}}, "the smaller must come first"),
        ("reset", {"scene": BOX | {"balls": 501}}, "at most 500"),
        ("reset", {"scene": BOX | {"balls": 400, "radii": [0.4, 0.5]}}, "do not fit into 6 m by"),
    ],
)
def test_an_impossible_input_is_refused_with_its_value(
    kind: str, values: dict[str, Any], says: str
) -> None:
    room = box(balls=1)
    before = room.checkpoint()
    with pytest.raises(PlinkoError) as refused:
        tell(room, kind, **values)
    assert says in str(refused.value)
    assert isinstance(refused.value, InvalidValueError)
    assert room.checkpoint() == before
    assert not room.planned


def test_a_full_room_takes_no_ball_and_too_much_work_is_refused() -> None:
    room = box(most=3, balls=3)
    with pytest.raises(BallLimitError, match="already has 3 balls"):
        tell(room, "add", x=0.0, y=1.0)
    large = box(balls=500, radii=[0.05, 0.05])
    with pytest.raises(InvalidValueError, match=f"more than {MOST_WORK}"):
        tell(large, "settings", dt=0.001, substeps=32)
    with pytest.raises(InvalidValueError, match="no board to drop on"):
        room.drop(DropCommand(1))
    with pytest.raises(MissingBallError, match="no ball 77"):
        tell(room, "kick", ball=77, vx=1.0)


def test_an_input_for_a_ball_that_has_gone_does_nothing() -> None:
    room = box(balls=1)
    kick = room.plan_change(change("kick", ball=0, vx=1.0), lead=2)
    take = room.plan_change(change("remove", ball=0))
    assert take.tick == kick.tick == 2, "inputs keep their order"
    room.refuse(kick)
    room.refuse(take)
    take = room.plan_change(change("remove", ball=0), lead=2)
    kick = room.plan_change(change("kick", ball=0, vx=1.0))
    take.durable = kick.durable = True
    run(room, 2)
    entered = room.enter()
    told = [[type(event).__name__ for event in each.events] for each in entered]
    assert told == [["Removed"], []]
    assert room.world.count == 0
    assert entered[0].failed is None
    assert isinstance(entered[1].failed, MissingBallError)
    assert "no ball 0" in str(entered[1].failed)


def aside(room: TouchingRoom) -> None:
    """Compute the next tick on another thread, if the room offers that."""
    compute = room.begin_step()
    if compute is not None:
        thread = threading.Thread(target=compute)
        thread.start()
        thread.join()


def test_ticks_that_another_thread_computes_have_the_same_bits() -> None:
    rng = random.Random(5)
    dear, plain = (box(balls=60, substeps=8, restitution=0.6, seed="9") for _ in range(2))
    assert dear.steps_aside
    asked: list[tuple[str, dict[str, Any]]] = [
        ("add", {"x": 0.0, "y": 0.5, "vx": 3.0}), ("kick", {"ball": 3, "vx": 2.0, "vy": -5.0}),
        ("drag", {"ball": 7, "x": 1.0, "y": 1.0}), ("settings", {"gravity": 3.0}),
        ("pause", {"paused": True}), ("step", {}), ("pause", {"paused": False}),
        ("remove", {"ball": 11}), ("reset", {}), ("release", {"ball": 7}), ("clear", {}),
    ]  # fmt: skip
    for kind, values in asked:
        for _ in range(rng.randrange(1, 12)):
            if dear.awake:
                aside(dear)
                assert dear.ready
                assert dear.begin_step() is None, "it is computed once"
                told = [room.step(watched=True) for room in (dear, plain)]
                assert told[0] == told[1]
        aside(dear)  # discarded, as an input comes before the tick
        assert tell(dear, kind, **values) == tell(plain, kind, **values)
        assert dear.checkpoint() == plain.checkpoint()
        assert dear.snapshot() == plain.snapshot()


def test_a_room_keeps_its_tick_while_the_next_is_computed() -> None:
    room = box(balls=60, substeps=8)
    run(room, 20)
    shown, kept = room.snapshot(), room.checkpoint()
    aside(room)
    assert (room.world.tick, room.snapshot(), room.checkpoint()) == (20, shown, kept)
    again = box(balls=60, substeps=8)
    again.restore(kept)
    run(room, 1)
    run(again, 1)
    assert again.checkpoint() == room.checkpoint()
    few = box(balls=10)
    assert (few.steps_aside, few.ready, few.begin_step()) == (False, True, None)


def test_no_ball_is_put_into_a_crowd_that_a_step_could_not_part() -> None:
    room = box()
    message = AddMessage(x=0.0, y=1.0, radius=0.1)
    for _ in range(MOST_OVERLAPS + 1):
        room.plan_change(message).durable = True
    with pytest.raises(BallLimitError, match="33 balls are at"):
        room.plan_change(message)  # planned changes count
    room.enter()
    with pytest.raises(BallLimitError, match="33 balls are at"):
        room.plan_change(AddMessage(x=0.15, y=1.0, radius=0.1))
    room.plan_change(AddMessage(x=0.5, y=1.0, radius=0.1))
    for _ in range(60):
        room.step(watched=False)
    assert room.world.count == MOST_OVERLAPS + 1
    # No drop joins a crowd either.
    room = table()
    for _ in range(MOST_OVERLAPS + 1):
        room.plan_drop(DropCommand(7)).durable = True
    with pytest.raises(BallLimitError):
        room.plan_drop(DropCommand(7))
