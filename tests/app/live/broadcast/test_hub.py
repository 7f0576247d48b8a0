"""Clients that do not read: the hub bounds their memory, delays no other, closes them."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plinko.app.errors import AppError, RoomFullError, SlowClientError
from plinko.app.live.broadcast.hub import Client, Hub, Mailbox, Traffic
from plinko.app.protocol.wire import WireMessage
from tests.kit.waiting import turns


def event(text: str) -> WireMessage:
    return WireMessage.of_text(text.encode())


def snapshot(tick: int) -> WireMessage:
    return WireMessage.of_bytes(b"%d" % tick)


def test_events_go_first_and_a_newer_snapshot_takes_the_place_of_the_older() -> None:
    mailbox = Mailbox(8, 1000)
    mailbox.show(snapshot(1))
    mailbox.post(event("a"))
    mailbox.post(event("b"))
    mailbox.show(snapshot(2))
    assert [mailbox.take() for _ in range(4)] == [event("a"), event("b"), snapshot(2), None]
    assert mailbox.replaced == 1


@given(st.lists(st.sampled_from(["post", "show", "take"])), st.integers(1, 5), st.integers(1, 50))
def test_a_mailbox_never_holds_more_than_its_bounds(
    acts: list[str], most: int, most_bytes: int
) -> None:
    mailbox = Mailbox(most, most_bytes)
    waiting: list[WireMessage] = []
    latest: WireMessage | None = None
    for count, act in enumerate(acts):
        if act == "post":
            new = event(f"event {count}")
            size = sum(len(frame.payload) for frame in [*waiting, new])
            if len(waiting) < most and size <= most_bytes:
                mailbox.post(new)
                waiting.append(new)
            else:
                with pytest.raises(SlowClientError):
                    mailbox.post(new)
        elif act == "show":
            latest = snapshot(count)
            mailbox.show(latest)
        else:
            expected = waiting.pop(0) if waiting else latest
            if expected is None or not expected.text:
                latest = None
            assert mailbox.take() == expected


class Wire:
    """A client's connection: it accepts frames, or blocks until the test releases it."""

    def __init__(self, *, direct: bool, blocked: bool = False) -> None:
        self.direct = direct
        self.frames: list[WireMessage] = []
        self.open = asyncio.Event()
        if not blocked:
            self.open.set()

    def write(self, wire: bytes) -> bool:
        if not (self.direct and self.open.is_set()):
            return False
        self.frames += unframed(wire)
        return True

    async def send(self, frame: WireMessage) -> None:
        await self.open.wait()
        self.frames.append(frame)


def unframed(wire: bytes) -> list[WireMessage]:
    """The messages of WebSocket frames shorter than 126 bytes."""
    frames = []
    while wire:
        size = wire[1]
        assert size <= 125
        payload, text = wire[2 : 2 + size], wire[0] == 0x81
        frames.append(WireMessage.of_text(payload) if text else WireMessage.of_bytes(payload))
        wire = wire[2 + size :]
    return frames


def client(connection: Wire, number: int = 0, grace: float = 60.0, most: int = 8) -> Client:
    return Client(number, connection, Mailbox(most, 10_000), grace)


@contextlib.asynccontextmanager
async def writing(*clients: Client) -> AsyncIterator[None]:
    """Run the clients' writers during the block."""
    writers = [asyncio.create_task(each.run()) for each in clients]
    yield
    for writer in writers:
        writer.cancel()
        with pytest.raises(asyncio.CancelledError):
            await writer


@pytest.mark.parametrize("direct", [True, False])
async def test_a_stalled_client_delays_no_other_and_skips_snapshots(direct: bool) -> None:
    hub = Hub(10)
    stuck, free = Wire(direct=direct, blocked=True), Wire(direct=direct)
    one, two = client(stuck, 1), client(free, 2)
    hub.join("r", one)
    hub.join("r", two)
    async with writing(one, two):
        for tick in range(100):
            hub.publish("r", "snapshots", None, b"%d" % tick)
            await turns()
        hub.announce("r", "snapshots", b"event")
        await turns()
        assert free.frames == [*(snapshot(tick) for tick in range(100)), event("event")]
        assert stuck.frames == []
        stuck.open.set()
        await turns()
        assert stuck.frames == [snapshot(0), event("event"), snapshot(99)]


@pytest.mark.parametrize("direct", [True, False])
async def test_a_stalled_client_gets_each_path_after_its_event(direct: bool) -> None:
    hub = Hub(10)
    stuck = Wire(direct=direct, blocked=True)
    one = client(stuck, 1)
    hub.join("r", one)
    async with writing(one):
        for number in range(3):
            hub.announce("r", "snapshots", b"accepted %d" % number)
            hub.post("r", "snapshots", b"path %d" % number)
            await turns()
        hub.post("r", "elsewhere", b"nobody")
        stuck.open.set()
        await turns()
    assert [frame.payload for frame in stuck.frames] == [
        text % number for number in range(3) for text in (b"accepted %d", b"path %d")
    ]


async def test_a_client_whose_events_pile_up_is_too_slow_at_once() -> None:
    slow = client(Wire(direct=True, blocked=True), grace=3600.0, most=8)
    writer = asyncio.create_task(slow.run())
    await turns()
    for number in range(20):
        slow.post(event(f"event {number}"))
        await turns(2)
    with pytest.raises(SlowClientError, match="8 event frames"):
        await writer


async def test_a_failed_client_ends_with_that_reason_even_when_idle() -> None:
    idle = client(Wire(direct=True))
    writer = asyncio.create_task(idle.run())
    await turns()
    idle.fail(AppError("the room is gone"))
    with pytest.raises(AppError, match="the room is gone"):
        await writer


@pytest.mark.parametrize("direct", [True, False])
async def test_the_sender_can_receive_another_message_than_the_rest(direct: bool) -> None:
    hub = Hub(10)
    connections = [Wire(direct=direct) for _ in range(3)]
    clients = [client(each, number) for number, each in enumerate(connections)]
    for each in clients:
        hub.join("r", each)
    async with writing(*clients):
        hub.announce("r", "snapshots", b"all but 1", 1, b"only 1")
        hub.announce("r", "paths", b"nobody")
        hub.announce("elsewhere", "snapshots", b"nobody")
        await turns()
    others = [event("all but 1")]
    assert [each.frames for each in connections] == [others, [event("only 1")], others]


@pytest.mark.parametrize("direct", [True, False])
async def test_a_ticks_events_and_snapshot_go_together_and_are_counted(direct: bool) -> None:
    hub = Hub(10)
    connections = [Wire(direct=direct) for _ in range(3)]
    clients = [
        Client(n, each, Mailbox(8, 1000), 60.0, stream=stream, traffic=hub.traffic)
        for n, (each, stream) in enumerate(zip(connections, ("a", "a", "b"), strict=True))
    ]
    for each in clients:
        hub.join("r", each)
    async with writing(*clients):
        await turns()
        hub.publish("r", "a", b"told", b"shown")
        hub.publish("r", "b", b"other", None)
        await turns()
    both = [event("told"), WireMessage.of_bytes(b"shown")]
    assert [each.frames for each in connections] == [both, both, [event("other")]]
    assert hub.traffic == Traffic(frames=5, bytes=2 * 9 + 5)
    assert (hub.count("r"), hub.count("r", "a"), hub.count("r", "b"), hub.total) == (3, 2, 1, 3)


async def test_a_client_silent_for_the_grace_period_is_given_up_and_counted() -> None:
    hub = Hub(10)
    slow = Client(1, Wire(direct=True, blocked=True), Mailbox(8, 1000), 0.01, traffic=hub.traffic)
    hub.join("r", slow)
    for tick in range(5):
        hub.publish("r", "snapshots", None, b"%d" % tick)
    with pytest.raises(SlowClientError, match=r"0\.01 seconds"):
        await slow.run()
    assert hub.traffic == Traffic(skipped=4, too_slow=1)


async def test_a_full_room_refuses_clients_an_empty_one_is_forgotten() -> None:
    hub = Hub(2)
    clients = [client(Wire(direct=True), number) for number in range(3)]
    hub.join("r", clients[0])
    hub.join("r", clients[1])
    with pytest.raises(RoomFullError, match="already has 2 clients"):
        hub.join("r", clients[2])
    assert hub.count("r") == 2
    for each in clients:
        hub.leave("r", each)
    assert hub.count("r") == 0
    hub.leave("r", clients[0])
    hub.join("r", clients[2])
    assert hub.count("r") == 1
