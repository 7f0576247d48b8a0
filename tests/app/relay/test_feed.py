"""A room and a relay on a bus in memory: spectators of both receive the same events."""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import msgspec

from plinko.app.errors import ClosedRoomError, LeaseLostError
from plinko.app.live.broadcast.hub import Client, Hub, Mailbox
from plinko.app.protocol.visitors import NO_TAG
from plinko.app.protocol.wire import WireMessage
from plinko.app.relay.feed import KEPT, Feeds
from plinko.app.relay.feed_messages import REQUESTS, channel_of, encode_request, payload_of
from plinko.app.relay.replica import Replica
from plinko.engine import Board
from tests.app.asking import ask
from tests.app.live.test_registry import finish
from tests.app.passes import rooms_by_hand, run_pass
from tests.app.relay.memory_bus import MemoryBus
from tests.kit.waiting import eventually, turns


@dataclass
class Ear:
    """A client of the stream `seeds`, which records its events."""

    number: int
    told: list[dict[str, Any]] = field(default_factory=list)
    handed_over: bool = False
    client: Client = field(init=False)

    def __post_init__(self) -> None:
        self.client = Client(self.number, self, Mailbox(8, 1 << 16), 60.0, stream="seeds", key="k")

    def write(self, wire: bytes) -> bool:
        events = msgspec.json.decode(payload_of(wire))
        self.told += events if isinstance(events, list) else [events]
        return True

    async def send(self, message: WireMessage) -> None:
        raise AssertionError("its connection has room")

    def hand_over(self) -> None:
        self.handed_over = True

    def since_hello(self) -> list[dict[str, Any]]:
        """The events received since the latest hello."""
        kinds = [event["type"] for event in self.told]
        return self.told[len(kinds) - kinds[::-1].index("hello") :]


@dataclass
class Scene:
    """Rooms with their feeds at one end of a bus, a relay at the other end, and a clock."""

    bus: MemoryBus = field(default_factory=MemoryBus)
    now: float = 10.0
    numbers: Iterator[int] = field(default_factory=count)
    kept: float = KEPT
    lost: int = 0  # how many of the next messages the bus loses

    def __post_init__(self) -> None:
        self.rooms = rooms_by_hand(Board.preset("triangle-8"))
        self.feeds = Feeds(
            self.bus.join(),
            self.rooms,
            new_client=self.numbers.__next__,
            clock=lambda: self.now,
            kept=self.kept,
        )
        self.relay = self.bus.join()

    def replica(self, room_id: str = "main") -> Replica:
        def request(hello: bool) -> None:
            self.relay.publish(REQUESTS, encode_request(room_id, hello=hello))

        def heard(data: bytes) -> None:
            if self.lost:
                self.lost -= 1
            else:
                found.take(data)

        found = Replica(room_id, Hub(64), request, lambda: self.now)
        self.relay.subscribe(channel_of(room_id), heard)
        return found

    def ear(self) -> Ear:
        return Ear(next(self.numbers))

    def direct(self) -> Ear:
        """A client that watches `main` without a relay."""
        ear = self.ear()
        self.rooms.enter(self.rooms.find("main"), ear.client)
        return ear


@contextmanager
def scene(kept: float = KEPT) -> Iterator[Scene]:
    found = Scene(kept=kept)
    try:
        yield found
    finally:
        found.feeds.close()


async def dropped(one: Scene, seed: int) -> None:
    """Drop into `main`, and tick until the ball has entered."""
    asked = ask(one.rooms.find("main"), seed)
    while not asked.done():
        run_pass(one.rooms.runner)
        await asyncio.sleep(0)


async def joined(replica: Replica, ear: Ear) -> Ear:
    replica.join(ear.client, ear.hand_over)
    await eventually(lambda: ear.told or ear.handed_over)
    return ear


async def test_a_relay_s_spectators_receive_the_same_events() -> None:
    with scene() as one:
        near = one.direct()
        replica = one.replica()
        far = await joined(replica, one.ear())
        for seed in range(3):
            await dropped(one, seed)
        late = await joined(replica, one.ear())
        for seed in range(3, 5):
            await dropped(one, seed)
        await finish(one.rooms)
        assert far.since_hello() == near.since_hello()
        assert [event["type"] for event in far.told].count("landed") == 5
        # The late client has the earlier balls in its hello, and the later events in order.
        heard = late.since_hello()
        assert [event["ball"] for event in heard if event["type"] == "accepted"] == [3, 4]
        assert heard == far.since_hello()[-len(heard) :]
        assert {ball["ball"] for ball in late.told[0]["balls"]} <= {0, 1, 2}
        assert late.told[0]["run"] == near.told[0]["run"]


async def test_a_client_of_a_relay_learns_what_waits_in_the_room() -> None:
    with scene() as one:
        replica = one.replica()
        early = await joined(replica, one.ear())
        queue = one.rooms.find("main").queue
        await queue.change(lambda state: state.halted(True))
        await queue.add(3, 1.0, NO_TAG)
        waits = {
            "type": "queue", "waiting": 3, "paused": True, "items": [{"number": 0, "left": 3}],
        }  # fmt: skip
        await eventually(lambda: waits in early.told)
        late = await joined(replica, one.ear())
        await eventually(lambda: waits in late.told)
        assert early.told[0]["type"] == late.told[0]["type"] == "hello"


async def test_each_room_s_relays_learn_that_the_server_stops() -> None:
    with scene() as one:
        ears = [await joined(one.replica(room), one.ear()) for room in ("main", "triangle-12")]
        one.rooms.tell_leaving()
        await eventually(lambda: all(ear.told[-1]["type"] == "notice" for ear in ears))


async def test_one_subscriber_is_all_that_the_room_sees() -> None:
    with scene() as one:
        replica = one.replica()
        for _ in range(20):
            await joined(replica, one.ear())
        assert one.rooms.hub.count("main") == 1
        assert one.feeds.count == 1


async def test_a_lost_message_is_made_good_by_a_hello() -> None:
    with scene() as one:
        near = one.direct()
        far = await joined(one.replica(), one.ear())
        one.lost = 1
        for seed in range(3):
            await dropped(one, seed)
        await eventually(lambda: [event["type"] for event in far.told].count("hello") == 2)
        await finish(one.rooms)
        balls = {ball["ball"] for ball in [*far.told[0]["balls"], *_second_hello(far)["balls"]]}
        accepted = {event["ball"] for event in far.told if event["type"] == "accepted"}
        assert balls | accepted == {0, 1, 2}
        assert near.since_hello()[-1] == far.since_hello()[-1]


def _second_hello(ear: Ear) -> dict[str, Any]:
    _, second = (event for event in ear.told if event["type"] == "hello")
    return second


async def test_a_feed_lasts_while_somebody_is_subscribed() -> None:
    with scene(kept=0.02) as one:
        await joined(one.replica(), one.ear())
        one.now += 1.0
        one.relay.publish(REQUESTS, encode_request("main", hello=False))
        await turns()
        assert one.feeds.count == 1
        one.now += 1.0
        await eventually(lambda: one.feeds.count == 0)
        assert one.rooms.hub.count("main") == 0


async def test_a_missing_or_differently_shown_room_goes_to_its_process() -> None:
    with scene() as one:
        for room_id in ("nowhere", "sandbox"):
            ear = await joined(one.replica(room_id), one.ear())
            assert ear.handed_over
            assert ear.told == []
        await eventually(lambda: one.feeds.count == 0)


async def test_a_room_that_moves_keeps_its_viewers_over_a_relay() -> None:
    with scene() as one:
        far = await joined(one.replica(), one.ear())
        other = Scene(bus=one.bus)
        one.rooms.hub.cut("main", LeaseLostError("at another server"))
        await eventually(lambda: [event["type"] for event in far.told].count("hello") == 2)
        assert _second_hello(far)["run"] != far.told[0]["run"]
        assert not far.handed_over
        await dropped(other, 1)
        await eventually(lambda: far.told[-1]["type"] == "accepted")
        other.feeds.close()


async def test_a_closed_room_hands_its_spectators_over() -> None:
    with scene() as one:
        far = await joined(one.replica(), one.ear())
        one.rooms.hub.close("main", ClosedRoomError("closed by its creator"))
        await eventually(lambda: far.handed_over)


async def test_a_process_answers_only_for_its_own_rooms() -> None:
    with scene() as one:
        one.feeds._holds = lambda room_id: room_id != "main"
        replica = one.replica()
        ear = one.ear()
        replica.join(ear.client, ear.hand_over)
        await turns()
        assert one.feeds.count == 0
        assert ear.told == []
