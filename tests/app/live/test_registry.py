"""Rooms in one server: a failed room ends no other, and closing a room ends its waits."""

import asyncio
import logging
from typing import Any

import msgspec
import pytest

from plinko.app.errors import AppError, MissingBallError
from plinko.app.live.broadcast.hub import Client, Mailbox
from plinko.app.live.registry import Rooms
from plinko.app.protocol.client_messages import DropMessage
from plinko.app.protocol.touching_messages import Change
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.kinds import SCENE
from plinko.app.settings import Settings
from plinko.app.web.drops import drop_command
from plinko.engine import Board, World, drop
from tests.app.asking import ask, change
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.waiting import turns

BOARD = Board.preset("triangle-8")


def rooms(**settings: Any) -> Rooms:
    return rooms_by_hand(BOARD, settings=Settings(**settings))


async def finish(held: Rooms) -> None:
    """Tick without a clock until nothing moves."""
    while run_pass(held.runner):
        await asyncio.sleep(0)


class Watcher:
    """A client that records the messages sent to it."""

    def __init__(self) -> None:
        self.frames: list[WireMessage] = []
        self.client = Client(0, self, Mailbox(256, 1 << 20), 60.0)

    def write(self, wire: bytes) -> bool:
        return False

    async def send(self, frame: WireMessage) -> None:
        self.frames.append(frame)

    def events(self) -> list[dict[str, Any]]:
        """The events in its text messages."""
        told = [
            msgspec.json.decode(each.payload) for each in self.frames if each.payload[:1] in b"{["
        ]
        return [event for each in told for event in (each if isinstance(each, list) else [each])]


@pytest.mark.parametrize(
    ("kind", "values"), [("kick", {"vx": 1.0}), ("drag", {"x": 0.0, "y": 1.0}), ("release", {})]
)
async def test_an_action_on_a_removed_ball_is_refused(kind: str, values: dict[str, Any]) -> None:
    held = rooms()
    room = await held.create(held.scene({"scene": "sandbox", "balls": 1}), SCENE)
    change(room, message("remove", ball=0))
    asked = change(room, message(kind, ball=0, **values))  # it is still there
    await turns()
    await finish(held)
    with pytest.raises(MissingBallError, match="no ball 0"):
        await asked
    with pytest.raises(MissingBallError, match="no ball 0"):
        await change(room, message(kind, ball=0, **values))


def message(kind: str, **values: Any) -> Change:
    asked: Change = msgspec.convert({"type": kind, **values}, Change)
    return asked


async def test_waiting_for_a_landing_gives_the_drops_own_end_or_none_when_time_is_over() -> None:
    held = rooms()
    room = held.find("main")
    accepted = await ask(room, 42)
    waits = [asyncio.create_task(room.landings.wait(accepted.ball, 60.0)) for _ in range(2)]
    await asyncio.sleep(0)
    await finish(held)
    for landed in await asyncio.gather(*waits):
        assert landed is not None
        assert landed.digest == drop(BOARD, 42).digest
    again = await room.landings.wait(accepted.ball, 60.0)
    assert again == landed, "a ball that has landed is not waited for"
    assert room.landings.waiting == 0
    second = await ask(room, 42)
    assert await room.landings.wait(second.ball, 0.01) is None
    assert room.landings.waiting == 0
    # The server stops.
    waiting = asyncio.create_task(room.landings.wait(second.ball, 3600.0))
    await turns()
    held.stop_waiting()
    assert await waiting is None


async def test_nothing_is_encoded_without_clients(monkeypatch: pytest.MonkeyPatch) -> None:
    held = rooms_by_hand(BOARD, draw=lambda: 42)
    assert drop_command(DropMessage(), held.draw).seed == 42, (
        "a drop's seed is drawn if it has none"
    )

    def forbidden(*_: object) -> bytes:
        raise AssertionError("a frame was encoded for nobody")

    monkeypatch.setattr("plinko.app.protocol.snapshots.encode_snapshot", forbidden)
    monkeypatch.setattr("plinko.app.protocol.messages.encode_events", forbidden)
    monkeypatch.setattr("plinko.app.protocol.messages.encode_event", forbidden)
    await ask(held.find("main"), 1)
    await finish(held)
    assert held.find("main").room.stats().drops == 1


async def test_the_request_at_which_a_room_failed_gets_the_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    held = rooms()
    room = held.find("triangle-8")

    def fail(room: IndependentRoom, *_: object) -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(IndependentRoom, "enter", fail)
    with pytest.raises(AppError, match="failed and was closed"):
        await ask(room, 42)
    assert not held.is_open("triangle-8")


async def test_a_room_that_fails_is_closed_and_the_others_go_on(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    held = rooms()
    broken, sound = held.find("triangle-8"), held.find("triangle-9")
    watcher = Watcher()
    held.enter(broken, watcher.client)
    writer = asyncio.create_task(watcher.client.run())
    lost = await ask(broken, 42, stake=5)
    kept = await ask(sound, 42)
    waits = [
        asyncio.create_task(room.landings.wait(ball.ball, 60.0))
        for room, ball in ((broken, lost), (sound, kept))
    ]
    await asyncio.sleep(0)

    step = World.step

    def fail(world: World, *, contacts: bool) -> None:
        if world is broken.room.world:
            raise ZeroDivisionError("a bug")
        step(world, contacts=contacts)

    monkeypatch.setattr(World, "step", fail)
    with caplog.at_level(logging.ERROR):
        await finish(held)
    (line,) = caplog.records
    assert vars(line)["room"] == "triangle-8"
    assert "ZeroDivisionError" in caplog.text
    with pytest.raises(AppError, match="failed and was closed"):
        await writer
    (told,) = (event for event in watcher.events() if event["type"] == "landed")
    for room, wait in zip((broken, sound), waits, strict=True):
        landed = await wait
        assert landed is not None
        assert isinstance(room.room.origin, Board)
        assert landed.digest == drop(room.room.origin, 42).digest
    assert (told["ball"], told["digest"]) == (0, drop(BOARD, 42).digest), "its flight was known"
    assert held.find("triangle-8") is not broken, "asked for again, it opens afresh"


async def test_an_empty_room_s_scene_stands_still_until_somebody_comes() -> None:
    """Without friction and gravity the scene would move for ever."""
    held = rooms()
    values = {"scene": "sandbox", "balls": 3, "gravity": 0.0, "speed": 1.0, "restitution": 1.0}
    room = await held.create(held.scene(values), "scene")
    watcher = Watcher()
    held.enter(room, watcher.client)
    for _ in range(700):
        run_pass(held.runner)
    assert room.ticks, "somebody watches"
    before = room.room.world.tick
    held.exit(room, watcher.client)
    for _ in range(700):
        run_pass(held.runner)
    assert (room.room.awake, room.ticks) == (True, False)
    left = room.room.world.tick
    assert before + 600 <= left <= before + 602
    assert not run_pass(held.runner), "no clock runs"
    held.enter(room, watcher.client)
    run_pass(held.runner)
    assert room.room.world.tick > left


async def test_what_is_changed_while_the_clock_stands_is_shown() -> None:
    held = rooms()
    room = await held.create(held.scene({"scene": "sandbox", "balls": 1}), SCENE)
    paused = change(room, message("pause", paused=True))
    await turns()
    await finish(held)
    await paused
    assert (room.room.awake, room.ticks) == (False, False)
    watcher = Watcher()
    held.enter(room, watcher.client)
    added = change(room, message("add", x=0.0, y=2.0))
    await turns()
    assert added.done()
    shown = watcher.client.mailbox.replaced
    run_pass(held.runner)
    assert watcher.client.mailbox.replaced == shown + 1, "a snapshot after that of the hello"


async def test_a_table_ticks_without_clients_until_drops_land() -> None:
    held = rooms()
    room = held.find("interacting-triangle-8")
    await ask(room, 1)
    await finish(held)
    assert room.room.seq == 2, "the acceptance and the landing; contacts had no listener"
    stats = room.room.stats()
    assert stats.drops == sum(stats.histogram) + stats.unsettled == 1
