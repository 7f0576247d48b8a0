"""Work that depends on a failed server is cancelled; a late server logs that it was late."""

import asyncio
import contextlib
import threading
from collections.abc import Iterable

import pytest

from plinko.app.cluster.alive import Alive, Heartbeats
from plinko.app.cluster.membership import HEARTBEAT, LEASE, Member, Seen
from plinko.app.persistence.lease_book import LeaseBook
from tests.kit.waiting import LIMIT, turns

A, B = Member("a.1", "a", ""), Member("b.1", "b", "http://b")


def beat(alive: Alive, *others: Member, age: float = HEARTBEAT) -> None:
    """A heartbeat of `A`, `age` seconds (by the database's clock) after the previous one."""
    found = [Seen(A, age, connected=True), *(Seen(each, 0.0, connected=True) for each in others)]
    alive.look(A, found)


def alive_with(others: Iterable[Member]) -> Alive:
    """`A` after it has seen itself and these others for the length of a lease."""
    alive = Alive("", LeaseBook("a.1"), "a")
    for _ in range(3):
        beat(alive, *others, age=LEASE / 2)
    return alive


async def test_a_block_that_depends_on_a_server_ends_once_it_is_gone() -> None:
    alive = alive_with([B])

    async def depend() -> None:
        async with alive.while_there(B):
            await asyncio.Event().wait()

    depending = asyncio.create_task(depend())
    await turns()
    alive.failed(TimeoutError())
    await turns()
    assert not depending.done(), "nothing is known of it"
    for _ in range(3):
        beat(alive, age=LEASE / 2)
    with pytest.raises(TimeoutError):
        await depending
    async with alive.while_there(A):
        beat(alive)
        await turns()


def test_a_late_server_doubts_only_itself(
    caplog: pytest.LogCaptureFixture,
) -> None:
    alive = alive_with([B])
    beat(alive, age=3 * LEASE)  # B may have had no time to send a heartbeat either
    (line,) = caplog.messages
    assert line.startswith("this server was late: its last heartbeat was 6.0 s ago")
    assert not alive.view.is_gone(B.holder)
    assert alive.view.up
    for _ in range(round(LEASE / HEARTBEAT)):
        beat(alive)
    assert alive.view.is_gone(B.holder), "it had a lease of the database's time to say so"
    assert len(caplog.messages) == 1


def test_others_are_doubted_only_when_postgresql_fails_and_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    alive = alive_with([B])
    beat(alive, B, age=LEASE - 0.1)
    assert caplog.messages == []
    for _ in range(3):
        alive.failed(TimeoutError("PostgreSQL has not answered for 2 s"))
    (line,) = caplog.messages
    assert line.startswith("heartbeats fail")
    beat(alive, B, age=3 * LEASE)
    assert len(caplog.messages) == 1, "the time without PostgreSQL is not this server's"


def test_a_heartbeat_after_the_end_calls_no_closed_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """PostgreSQL may answer only after the server has given up waiting for it."""
    asked, answers = threading.Event(), threading.Event()
    errors: list[threading.ExceptHookArgs] = []

    class Slow:
        def send(self, me: Member) -> list[Seen]:
            asked.set()
            assert answers.wait(LIMIT)
            return [Seen(me, HEARTBEAT, connected=True)]

        def pause(self) -> None:
            """The end is near."""

    monkeypatch.setattr(Heartbeats, "connected", lambda _: contextlib.nullcontext(Slow()))
    monkeypatch.setattr(
        "plinko.app.cluster.alive.LEASE", 0.0
    )  # how long the end waits for the thread
    monkeypatch.setattr(threading, "excepthook", errors.append)

    async def serve() -> None:
        running = asyncio.create_task(Alive("", LeaseBook("a.1"), "a").run())
        await asyncio.to_thread(asked.wait, LIMIT)
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await running

    asyncio.run(serve())
    (heartbeats,) = (each for each in threading.enumerate() if each.name == "heartbeats")
    answers.set()
    heartbeats.join(LIMIT)
    assert not heartbeats.is_alive()
    assert errors == []
