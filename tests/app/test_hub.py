"""Clients that do not read: bounded memory, nobody else delayed, closed with a reason."""

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import AppError, RoomFullError, SlowClientError
from app.hub import Client, Frame, Hub, Mailbox


def test_a_newer_snapshot_takes_the_place_of_the_older() -> None:
    mailbox = Mailbox(8, 1000)
    mailbox.show(b"1")
    mailbox.show(b"2")
    assert mailbox.take() == b"2"
    assert mailbox.take() is None
    assert mailbox.replaced == 1


def test_events_go_first_and_in_order() -> None:
    mailbox = Mailbox(8, 1000)
    mailbox.show(b"snapshot")
    mailbox.post("a")
    mailbox.post("b")
    assert [mailbox.take() for _ in range(4)] == ["a", "b", b"snapshot", None]


@given(st.lists(st.sampled_from(["post", "show", "take"])), st.integers(1, 5), st.integers(1, 50))
def test_a_mailbox_never_holds_more_than_its_bounds(
    acts: list[str], most: int, most_bytes: int
) -> None:
    mailbox = Mailbox(most, most_bytes)
    waiting: list[str] = []
    snapshot: bytes | None = None
    for count, act in enumerate(acts):
        if act == "post":
            event = f"event {count}"
            fits = len(waiting) < most and sum(map(len, waiting)) + len(event) <= most_bytes
            if fits:
                mailbox.post(event)
                waiting.append(event)
            else:
                with pytest.raises(SlowClientError):
                    mailbox.post(event)
        elif act == "show":
            snapshot = b"%d" % count
            mailbox.show(snapshot)
        else:
            expected: Frame | None = waiting.pop(0) if waiting else snapshot
            if not isinstance(expected, str):
                snapshot = None
            assert mailbox.take() == expected


class Line:
    """What a client's connection does: takes frames, or blocks until let go."""

    def __init__(self, blocked: bool = False) -> None:
        self.frames: list[Frame] = []
        self.open = asyncio.Event()
        if not blocked:
            self.open.set()

    async def send(self, frame: Frame) -> None:
        await self.open.wait()
        self.frames.append(frame)


def client(line: Line, number: int = 0, grace: float = 60.0, most: int = 8) -> Client:
    return Client(number, line.send, Mailbox(most, 10_000), grace)


async def turns(count: int = 20) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


async def stop(task: "asyncio.Task[None]") -> None:
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


async def test_a_stalled_client_delays_nobody_and_misses_only_old_snapshots() -> None:
    hub = Hub(10)
    stuck, free = Line(blocked=True), Line()
    one, two = client(stuck, 1), client(free, 2)
    hub.join("r", one)
    hub.join("r", two)
    writers = [asyncio.create_task(each.write()) for each in (one, two)]
    for tick in range(100):
        hub.show("r", b"%d" % tick)
        await turns()
    hub.announce("r", b"event")
    await turns()
    assert free.frames == [*(b"%d" % tick for tick in range(100)), "event"]
    assert stuck.frames == []
    stuck.open.set()
    await turns()
    assert stuck.frames == [b"0", "event", b"99"]
    for writer in writers:
        await stop(writer)


async def test_a_client_that_reads_nothing_for_the_grace_period_is_too_slow() -> None:
    slow = client(Line(blocked=True), grace=0.01)
    slow.show(b"x")
    with pytest.raises(SlowClientError, match=r"0\.01 seconds"):
        await slow.write()


async def test_a_client_whose_events_pile_up_is_too_slow_at_once() -> None:
    slow = client(Line(blocked=True), grace=3600.0, most=8)
    writer = asyncio.create_task(slow.write())
    await turns()
    for number in range(20):
        slow.post(f"event {number}")
        await turns(2)
    with pytest.raises(SlowClientError, match="8 event frames"):
        await writer


async def test_a_failed_client_ends_with_that_reason_even_when_idle() -> None:
    idle = client(Line())
    writer = asyncio.create_task(idle.write())
    await turns()
    idle.fail(AppError("the room is gone"))
    with pytest.raises(AppError, match="the room is gone"):
        await writer


async def test_everyone_but_the_one_skipped_is_told() -> None:
    hub = Hub(10)
    lines = [Line() for _ in range(3)]
    clients = [client(line, number) for number, line in enumerate(lines)]
    writers = [asyncio.create_task(each.write()) for each in clients]
    for each in clients:
        hub.join("r", each)
    hub.announce("r", b"all but 1", skip=1)
    hub.tell("r", 1, b"only 1")
    hub.tell("r", 99, b"nobody")
    hub.announce("elsewhere", b"nobody")
    await turns()
    assert [line.frames for line in lines] == [["all but 1"], ["only 1"], ["all but 1"]]
    for writer in writers:
        await stop(writer)


async def test_a_full_room_takes_nobody_and_an_empty_one_is_forgotten() -> None:
    hub = Hub(2)
    clients = [client(Line(), number) for number in range(3)]
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
