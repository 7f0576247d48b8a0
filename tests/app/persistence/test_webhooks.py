"""Webhooks are stored in the same transaction as drops and results, and sent at least once."""

import asyncio
import dataclasses
import signal
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx
import msgspec
import pytest

from plinko.app.errors import LedgerError
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import webhook_store
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.records import (
    BoardRow,
    Close,
    DropRow,
    NewDrop,
    Prune,
    Received,
    ResultRow,
    RoomRow,
    Void,
    Write,
)
from plinko.app.webhooks.sender import FIRST, LONGEST, LOOK, MOST, Sender
from plinko.app.webhooks.targets import Target
from plinko.engine import Board
from tests.app.conftest import QUICK
from tests.app.webhooks.target import SECRET, URL, FakeTarget, FlakyTarget
from tests.kit.facts import new
from tests.kit.process import ServerProcess
from tests.kit.waiting import eventually

BOARD = Board.preset("triangle-8")
TARGET = Target(URL, SECRET)
RUN = 1


def begun() -> list[Write]:
    board = BoardRow(BOARD.digest, BOARD.name, BOARD.to_json())
    return [board, RoomRow(RUN, "show", BOARD.digest, "independent", False, 60, 5, 0.0, 0.0)]


def drop(ball: int, stake: int = 0) -> NewDrop:
    return new(DropRow(RUN, ball, 10 * ball, seed=ball, stake=stake), used=1.0)


def result(ball: int) -> ResultRow:
    return ResultRow(RUN, ball, 10 * ball + 99, 4, 1.0, 1.5, 0.0, f"{ball:064}", None)


@asynccontextmanager
async def opened(url: str, targets: Sequence[str] = (URL,)) -> AsyncIterator[Ledger]:
    ledger = Ledger(Database(url), period=0.0, patience=5.0, targets=targets)
    ledger.open()
    ledger.start()
    try:
        yield ledger
    finally:
        await ledger.close()


async def ids(ledger: Ledger, target: str = URL) -> list[tuple[int, str]]:
    found = await ledger.read(webhook_store.waiting, target=target, most=MOST)
    return [(row["ball"], row["event"]) for row in found.events]


async def test_each_target_gets_each_drop_and_each_result_once(url: str) -> None:
    async with opened(url, (URL, "http://other.test")) as ledger:
        await ledger.commit(*begun(), drop(0), drop(1))
        await ledger.commit(result(1))
        await ledger.commit(result(1), result(0))  # computed again, as after a crash
        for target in (URL, "http://other.test"):
            assert await ids(ledger, target) == [
                (0, "accepted"), (1, "accepted"), (0, "landed"), (1, "landed")
            ]  # fmt: skip
        one = await ledger.read(webhook_store.waiting, target=URL, most=1)
        await ledger.commit(*one.cursors)
        assert len(await ids(ledger)) == 3
        assert len(await ids(ledger, "http://other.test")) == 4


async def test_a_refused_drop_is_sent_to_no_target(url: str) -> None:
    async with opened(url) as ledger:
        await ledger.commit(*begun(), drop(0))
        with pytest.raises(LedgerError):
            await ledger.commit(drop(1), drop(2, stake=-1))
        assert await ids(ledger) == [(0, "accepted")]


async def test_a_voided_ball_is_sent_as_landed(url: str) -> None:
    async with opened(url) as ledger:
        await ledger.commit(*begun(), drop(0, stake=100))
        await ledger.commit(Void(RUN, 50, "given up"), Close(RUN, 50, 1.0))
        assert await ids(ledger) == [(0, "accepted"), (0, "landed")]


async def test_a_new_target_gets_what_happens_from_now_on(url: str) -> None:
    async with opened(url, ()) as ledger:
        await ledger.commit(*begun(), drop(0), drop(1))
        await ledger.commit(result(0))
        assert await ids(ledger) == []
        await ledger.commit(*await ledger.read(webhook_store.follow, target=URL))
        assert await ids(ledger) == []
        await ledger.commit(drop(2), result(1))
        assert await ids(ledger) == [(2, "accepted"), (1, "landed")]
        assert await ledger.read(webhook_store.follow, target=URL) == []


async def test_pruning_a_room_ends_its_events(url: str) -> None:
    async with opened(url) as ledger:
        await ledger.commit(*begun(), drop(0), result(0), Close(RUN, 50, 1.0))
        assert await ids(ledger) == [(0, "accepted"), (0, "landed")]
        step = Prune(RUN, before=2.0)
        await ledger.commit(step)
        assert (step.rooms, step.drops) == (1, 1)
        assert await ids(ledger) == []


async def test_more_boards_are_sent_than_are_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plinko.app.webhooks.sender.MOST_BOARDS", 1)
    target = FakeTarget()
    board, room = begun()
    assert isinstance(board, BoardRow)
    assert isinstance(room, RoomRow)
    other = dataclasses.replace(board, digest="f" * 64)
    second = dataclasses.replace(room, number=2, id="other", board=other.digest)
    async with opened(f"sqlite:///{tmp_path / 'plinko.db'}") as ledger:
        await ledger.commit(board, other, room, second, drop(0))
        sending = Sending(ledger, target)
        task = asyncio.create_task(sending.sender.run())
        await eventually(lambda: target.heard or task.done())
        await ledger.commit(drop(1), dataclasses.replace(drop(0), room=2))
        await eventually(lambda: len(target.heard) == 3 or task.done())
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await sending.http.aclose()
    assert sorted(target.ids) == ["1.0.accepted", "1.1.accepted", "2.0.accepted"]


class Sending:
    """A sender whose waits take no time; `waited` lists the waits between attempts."""

    def __init__(self, ledger: Ledger, target: FakeTarget, patience: float = 10.0) -> None:
        self.waited: list[float] = []
        self.http = httpx.AsyncClient(transport=target.transport)
        self.sender = Sender(
            TARGET, ledger, self.http, now=lambda: 1e9, sleep=self._sleep, patience=patience
        )

    async def _sleep(self, seconds: float) -> None:
        if seconds != LOOK:
            self.waited.append(seconds)
        await asyncio.sleep(0)

    async def until_heard(self, target: FakeTarget, events: int) -> None:
        task = asyncio.create_task(self.sender.run())
        await eventually(lambda: len(target.heard) >= events or task.done())
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await self.http.aclose()


@pytest.mark.parametrize("fault", [500, 302, 410, httpx.ConnectError("refused"), "hangs"], ids=str)
async def test_a_failing_target_gets_all_in_order_once_well(fault: Any, tmp_path: Path) -> None:
    target = FakeTarget([fault] * 3)

    async with opened(f"sqlite:///{tmp_path / 'plinko.db'}") as ledger:
        await ledger.commit(*begun(), *(drop(ball) for ball in range(MOST)))
        await ledger.commit(*(result(ball) for ball in reversed(range(MOST))))
        sending = Sending(ledger, target, 0.05 if fault == "hangs" else 10.0)
        await sending.until_heard(target, 2 * MOST)
    events = [(10 * ball + wait, f"1.{ball}.{event}") for ball in range(MOST)
              for wait, event in ((0, "accepted"), (99, "landed"))]  # fmt: skip
    assert target.ids == [name for _, name in sorted(events, key=lambda event: event[0])]
    assert sending.waited == [FIRST, 2 * FIRST, 4 * FIRST]
    assert len(set(target.bodies[:4])) == 1  # every attempt sends the same body


async def test_events_whose_cursor_was_not_moved_are_sent_again(tmp_path: Path) -> None:
    target = FakeTarget()

    class Forgetful(Ledger):
        refusals = 2

        async def commit(self, *writes: Write, use: KeyUse | None = None) -> None:
            if isinstance(writes[-1], Received) and self.refusals:
                self.refusals -= 1
                raise LedgerError("not now")
            await super().commit(*writes, use=use)

    database = Database(f"sqlite:///{tmp_path / 'plinko.db'}")
    ledger = Forgetful(database, period=0.0, patience=5.0, targets=(URL,))
    ledger.open()
    ledger.start()
    await ledger.commit(*begun(), drop(0))
    await Sending(ledger, target).until_heard(target, 3)
    await ledger.close()
    assert target.ids[:3] == ["1.0.accepted"] * 3


async def test_a_prize_is_sent_with_its_winner(tmp_path: Path) -> None:
    target = FakeTarget()
    form = msgspec.json.decode(BOARD.to_json())
    form["bins"]["labels"] = [{"text": f"prize {number}"} for number in range(9)]
    prizes = Board.from_json(form)
    _, room = begun()
    assert isinstance(room, RoomRow)
    async with opened(f"sqlite:///{tmp_path / 'plinko.db'}") as ledger:
        row = BoardRow(prizes.digest, prizes.name, prizes.to_json())
        named = new(DropRow(RUN, 0, 0, seed=0, name="Ann", colour="#00ff00"), 1.0)
        await ledger.commit(row, dataclasses.replace(room, board=prizes.digest), named)
        await ledger.commit(result(0))
        await Sending(ledger, target).until_heard(target, 2)
    assert [event.get("label") for event in target.heard] == [None, "prize 4"]
    assert [(event["name"], event["colour"]) for event in target.heard] == 2 * [("Ann", "#00ff00")]


async def test_a_sender_that_fails_says_so_and_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    target = FakeTarget([ZeroDivisionError("a fault of the program")])

    async with opened(f"sqlite:///{tmp_path / 'plinko.db'}") as ledger:
        await ledger.commit(*begun(), drop(0))
        sending = Sending(ledger, target)
        await sending.until_heard(target, 1)
    assert target.ids == ["1.0.accepted"]
    assert sending.waited == [LONGEST]
    assert "a fault of the program" in caplog.text


async def test_a_target_gets_every_ball_despite_failures_and_a_kill(tmp_path: Path) -> None:
    """20 drops, a target that answers every other request with 500, and a killed server."""
    target = FlakyTarget()
    server = ServerProcess(f"sqlite:///{tmp_path / 'plinko.db'}", target.options(tmp_path))
    room = ""

    async def drop_ten(first: int) -> None:
        async with server.async_client() as http:
            for seed in range(first, first + 10):
                form = {"seed": str(seed)}
                reply = await http.post(f"/api/v1/rooms/{room}/drops", json=form)
                reply.raise_for_status()

    with server:
        async with server.async_client() as http:
            made = await http.post("/api/v1/rooms", json={"board": QUICK})
        room = made.json()["id"]
        async with target.served():
            await drop_ten(0)
            await eventually(lambda: target.heard)
            server.end(signal.SIGKILL)
            await asyncio.to_thread(server.start)
            await drop_ten(10)
            await target.has_heard_of(20)
