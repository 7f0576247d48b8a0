"""A relay's room: spectators wait for a hello, and get another after a lost message."""

from dataclasses import dataclass, field
from typing import Any

import msgspec
import pytest

from plinko.app.errors import MalformedError, RoomFullError
from plinko.app.live.broadcast.hub import Client, Hub, Mailbox
from plinko.app.protocol.messages import Limits
from plinko.app.protocol.wire import WireMessage
from plinko.app.relay import replica as rules
from plinko.app.relay.feed import KEPT, TOGETHER
from plinko.app.relay.feed_messages import (
    END,
    EVENTS,
    HELLO,
    FeedMessage,
    decode,
    decode_request,
    encode_request,
    kind_of,
    payload_of,
)
from plinko.app.relay.replica import Replica
from plinko.app.rooms.independent import IndependentRoom
from plinko.engine import Board

ROOM = IndependentRoom("main", Board.preset("triangle-8"), tick_rate=60, max_balls=8)


def hello(run: str = "r1") -> bytes:
    """The room's hello in this run."""
    limits = Limits(8, 1.0, 4096)
    told = msgspec.structs.replace(ROOM.hello(50.0, limits, "seeds"), run=run, key="feed")
    return msgspec.json.encode(told)


@dataclass
class Watching:
    """A client of a relay that records its events."""

    number: int
    heard: list[Any] = field(default_factory=list)
    handed_over: int = 0
    client: Client = field(init=False)

    def __post_init__(self) -> None:
        self.client = Client(
            self.number, self, Mailbox(8, 1 << 16), 60.0, stream="seeds", key=f"key-{self.number}"
        )

    def write(self, wire: bytes) -> bool:
        told = msgspec.json.decode(payload_of(wire))
        self.heard += told if isinstance(told, list) else [told]
        return True

    async def send(self, message: WireMessage) -> None:
        raise AssertionError("its connection has room")

    @property
    def kinds(self) -> list[str]:
        return [event["type"] for event in self.heard]

    def hand_over(self) -> None:
        self.handed_over += 1


@dataclass
class Relay:
    """A replica whose clock the test sets, and the requests that it has sent."""

    limit: int = 8
    now: float = 100.0
    requests: list[bool] = field(default_factory=list)
    numbers: int = 0
    feed: bytes = b"feed-one"

    def __post_init__(self) -> None:
        self.replica = Replica("main", Hub(self.limit), self.requests.append, lambda: self.now)

    def joined(self, number: int = 0) -> Watching:
        one = Watching(number)
        self.replica.join(one.client, one.hand_over)
        return one

    def message(self, kind: int, payload: bytes = b"", **more: Any) -> FeedMessage:
        self.numbers += 1
        sent = {"tick": 7, "tick_time": 40.0, "now": 41.0} | more
        return FeedMessage(kind, self.feed, self.numbers, payload=payload, **sent)

    def hear(self, kind: int, payload: bytes = b"", **more: Any) -> None:
        self.replica.take(self.message(kind, payload, **more).encode())

    def happens(self, ball: int) -> None:
        self.hear(EVENTS, msgspec.json.encode({"type": "landed", "ball": ball, "digest": "0"}))


def test_a_new_client_receives_the_hello_and_then_events() -> None:
    relay = Relay()
    first, second = relay.joined(1), relay.joined(2)
    assert relay.requests == [True], "one hello serves all waiting clients"
    relay.happens(0)
    assert first.heard == []
    relay.hear(HELLO, hello())
    relay.happens(1)
    third = relay.joined(3)
    relay.happens(2)
    relay.hear(HELLO, hello())
    relay.happens(3)
    assert first.kinds == second.kinds == ["hello", "landed", "landed", "landed"]
    assert third.kinds == ["hello", "landed"]
    assert [event["ball"] for event in first.heard[1:]] == [1, 2, 3]
    assert [each.heard[0]["key"] for each in (first, third)] == ["key-1", "key-3"]


def test_after_a_missing_message_all_wait_for_a_hello() -> None:
    relay = Relay()
    one = relay.joined()
    relay.hear(HELLO, hello())
    relay.numbers += 1
    relay.happens(5)
    relay.happens(6)
    assert one.kinds == ["hello"], "events after a gap might arrive twice or wrong"
    assert relay.requests[1:] == [True, True]
    relay.hear(HELLO, hello())
    relay.happens(7)
    assert one.kinds == ["hello", "hello", "landed"]


def test_another_process_of_the_room_restarts_all_clients() -> None:
    relay = Relay()
    one = relay.joined()
    relay.hear(HELLO, hello("r1"))
    relay.feed, relay.numbers = b"feed-two", 0
    relay.hear(HELLO, hello("r2"))
    relay.happens(1)
    assert one.kinds == ["hello", "hello", "landed"]


def test_a_reset_is_everyone_s_and_a_greeting_is_not() -> None:
    relay = Relay()
    one = relay.joined()
    relay.hear(HELLO, hello("r1"))
    relay.hear(HELLO, hello("r1"))
    assert one.kinds == ["hello"]
    relay.hear(HELLO, hello("r2"))
    assert one.kinds == ["hello", "hello"]


def test_times_are_those_of_the_relay_s_own_clock() -> None:
    relay = Relay()
    one = relay.joined()
    assert relay.replica.pong(1.5) is None
    # The room's clock is 59 s behind. This message took 0.2 s, the next takes no time.
    relay.now = 100.2
    relay.hear(HELLO, hello(), tick=7, tick_time=40.9, now=41.0)
    relay.now = 101.0
    relay.hear(EVENTS, b'{"type":"clock"}', tick=67, tick_time=41.9, now=42.0)
    relay.now = 101.5
    pong = relay.replica.pong(1.5)
    assert pong is not None
    assert (pong.t, pong.tick) == (1.5, 67)
    assert pong.tick_time == pytest.approx(41.9 + 59.0)
    assert pong.server_time == 101.5
    assert one.heard[0]["server_time"] == pytest.approx(50.0 + 59.2)


def test_a_client_that_waited_too_long_is_handed_over() -> None:
    relay = Relay()
    one = relay.joined(1)
    relay.now += rules.PATIENCE + 0.1
    late = relay.joined(2)
    relay.replica.tend()
    assert (one.handed_over, late.handed_over) == (1, 0)
    assert relay.replica.count == 1


def test_without_the_room_s_process_all_are_handed_over() -> None:
    relay = Relay()
    one = relay.joined()
    relay.hear(HELLO, hello())
    relay.now += 1.0
    relay.replica.tend()
    assert relay.requests[-1] is False, "messages continue"
    relay.now += rules.QUIET
    relay.replica.tend()
    assert relay.requests[-1] is True, "is anybody there?"
    assert one.handed_over == 0
    relay.now += rules.GONE
    relay.replica.tend()
    assert one.handed_over == 1
    assert relay.replica.count == 0


def test_a_room_that_ends_hands_everyone_over() -> None:
    relay = Relay()
    one, waiting = relay.joined(1), None
    relay.hear(HELLO, hello())
    waiting = relay.joined(2)
    relay.hear(END)
    assert (one.handed_over, waiting.handed_over) == (1, 1)
    assert one.kinds == ["hello"]


def test_a_full_room_refuses_and_former_clients_get_nothing() -> None:
    relay = Relay(limit=1)
    one = relay.joined(1)
    with pytest.raises(RoomFullError, match="main"):
        relay.joined(2)
    relay.hear(HELLO, hello())
    relay.replica.leave(one.client)
    relay.happens(1)
    assert one.kinds == ["hello"]
    again = relay.joined(3)
    relay.happens(2)
    assert again.heard == [], "former messages do not count"


def test_messages_and_requests_come_back_from_their_bytes() -> None:
    message = Relay().message(EVENTS, b"[]", tick=2**40)
    assert decode(message.encode()) == message
    for room, wanted in (("main", True), ("é", False)):
        assert decode_request(encode_request(room, hello=wanted)) == (room, wanted)
    for bad in (b"", b"h", b"xmain", b"h\xff"):
        with pytest.raises(MalformedError):
            decode_request(bad)
    with pytest.raises(MalformedError, match="too short"):
        decode(b"x" * 8)


@pytest.mark.parametrize("size", [1, 125, 126, 65_535, 65_536])
def test_a_message_carries_what_a_client_is_written(size: int) -> None:
    payload = b"[" * size
    assert payload_of(WireMessage.of_text(payload).wire) == payload
    assert kind_of(payload) == EVENTS
    assert kind_of(hello()) == HELLO


def test_the_limits_of_the_two_sides_fit() -> None:
    assert KEPT > 2.0, "a relay asks once a second, and one request may be lost"
    assert TOGETHER < rules.PATIENCE / 10.0
