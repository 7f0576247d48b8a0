"""The stream `seeds`: a client computes the same drops as the room from its events."""

import json
from typing import Any

from plinko.app.live.broadcast.audience import Audience, AudienceContext, Player
from plinko.app.live.broadcast.hub import Client, Hub, Mailbox
from plinko.app.live.broadcast.presence import Presence
from plinko.app.protocol import messages
from plinko.app.protocol.seeds import DIGITS
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.app.settings import Settings
from plinko.engine import Board, drop
from tests.app.conftest import TINY

BOARD = Board.from_json(TINY)
RATE = 60


class Ear:
    """A connection that records the bytes written to it."""

    def __init__(self) -> None:
        self.wire: list[bytes] = []

    def write(self, wire: bytes) -> bool:
        self.wire.append(wire)
        return True

    async def send(self, message: Any) -> None:
        raise AssertionError("it always has room")

    @property
    def messages(self) -> list[list[dict[str, Any]]]:
        """The events of each text frame."""
        told = []
        for wire in self.wire:
            assert wire[0] == 0x81, "a text frame, and never a binary one"
            begin = 2 if wire[1] < 126 else 4
            said = json.loads(wire[begin:])
            told.append(said if isinstance(said, list) else [said])
        return told

    @property
    def events(self) -> list[dict[str, Any]]:
        return [event for message in self.messages for event in message]


class Watched:
    """A room, ticked by hand, with clients of the stream `seeds`."""

    def __init__(self, presence: Presence | None = None) -> None:
        self.hub = Hub(10)
        self.room = IndependentRoom("r", BOARD, tick_rate=RATE, max_balls=100)
        context = AudienceContext.of(self.hub, Settings(), lambda: 0.0, presence=presence)
        self.audience = Audience(context, self.room, "a")

    def join(self, number: int = 1, stream: str = messages.SEEDS) -> Ear:
        ear = Ear()
        client = Client(number, ear, Mailbox(9, 9999), 1.0, stream=stream)
        self.audience.enter(client)
        return ear

    def drop(self, seed: int, x: float | None = None, client: int | None = None) -> None:
        event = self.room.drop(DropCommand(seed, x))
        self.audience.announce(self.room.seq, Player(client=client, ref="mine"), event)

    def tick(self, times: int = 1) -> None:
        for _ in range(times):
            events = self.room.step(watched=False)
            self.audience.broadcast(events, with_snapshot=True)

    def run(self) -> None:
        while self.room.awake:
            self.tick()


def test_clients_recompute_every_drop_from_the_events() -> None:
    watched = Watched()
    ear = watched.join()
    for seed in range(6):
        watched.drop(seed, x=0.1 if seed == 3 else None)
        watched.tick(5)
    watched.run()
    accepted = {e["ball"]: e for e in ear.events if e["type"] == "accepted"}
    landed = {e["ball"]: e for e in ear.events if e["type"] == "landed"}
    assert accepted.keys() == landed.keys() == set(range(6))
    assert [ball for ball, event in accepted.items() if "x" in event] == [3]
    for ball, event in accepted.items():
        told = drop(BOARD, event["seed"], x=event.get("x"))
        assert landed[ball]["digest"] == told.digest[:DIGITS]
    assert not any(e["type"] == "contact" for e in ear.events)
    # The clock is sent once a second while balls move.
    clocks = [event["tick"] for event in ear.events if event["type"] == "clock"]
    assert clocks == list(range(RATE, watched.room.world.tick, RATE)) != []


def test_landings_are_grouped_for_a_tenth_of_a_second_at_most() -> None:
    watched = Watched()
    ear = watched.join()
    for seed in range(40):
        watched.drop(seed)
        watched.tick()
    ends: dict[int, int] = {}
    while watched.room.awake:
        before = len(ear.wire)
        events = watched.room.step(watched=False)
        ends |= {e.ball: e.tick for e in events if isinstance(e, messages.Landed)}
        watched.audience.broadcast(events)
        for told in (told for message in ear.messages[before:] for told in message):
            if told["type"] == "landed":
                assert watched.room.world.tick - ends.pop(told["ball"]) <= RATE // 10
    assert ends == {}
    assert len([m for m in ear.messages if m[0]["type"] == "landed"]) < 40


def test_a_late_client_receives_no_landing_before_its_hello() -> None:
    watched = Watched()
    early = watched.join(1)
    watched.drop(7)
    watched.drop(8)
    while not (landed := watched.room.drops - watched.room.world.count):
        watched.tick()
    late = watched.join(2)
    hello = late.events[0]
    assert len(hello["balls"]) == 2 - landed
    watched.run()
    known = {ball["ball"] for ball in hello["balls"]}
    assert {e["ball"] for e in late.events if e["type"] == "landed"} == known
    assert {e["ball"] for e in early.events if e["type"] == "landed"} == {0, 1}


def test_only_the_player_receives_a_drop_s_ref() -> None:
    watched = Watched()
    own, other = watched.join(1), watched.join(2)
    whole = watched.join(3, messages.PATHS)
    watched.drop(7, client=1)
    assert own.events[-1]["ref"] == "mine"
    assert "ref" not in other.events[-1]
    accepted, _path = whole.wire[-2:]
    assert json.loads(accepted[2:] if accepted[1] < 126 else accepted[4:])["x"]


def test_a_delayed_landing_is_sent_with_the_next_event() -> None:
    watched = Watched()
    ear = watched.join()
    for seed in range(2):
        watched.drop(seed)
    while watched.room.world.count == 2:
        watched.tick()
    watched.drop(9)
    landed, accepted = ear.messages[-1]
    assert (landed["type"], accepted["type"]) == ("landed", "accepted")
