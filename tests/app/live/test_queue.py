"""A room's queue: queued balls are dropped exactly once and in order, also after a restart."""

import asyncio
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.errors import BallLimitError
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.queue import MOST_FALLING, RoomQueue
from plinko.app.protocol import messages
from plinko.app.protocol.visitors import NO_TAG
from plinko.app.rooms.outcome import Outcome
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.queue import EMPTY, MOST_BALLS, MOST_ITEMS, MOST_WAITING
from tests.app.conftest import QUICK
from tests.app.live.test_tags import TAG, opened
from tests.kit.null_ledger import NullLedger
from tests.kit.player import playing
from tests.kit.serving import Running, serving
from tests.kit.waiting import eventually, turns, until
from tests.long import tries


def queue_of(http: httpx.Client, room: str) -> dict[str, Any]:
    found: dict[str, Any] = http.get(f"/api/v1/rooms/{room}/queue").raise_for_status().json()
    return found


def dropped(http: httpx.Client, room: str) -> list[dict[str, Any]]:
    drops: list[dict[str, Any]] = http.get(f"/api/v1/rooms/{room}/log").json()["drops"]
    return drops


async def test_queued_balls_are_dropped_in_order_with_their_names(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http, QUICK)
    path = f"/api/v1/rooms/{room}/queue"
    http.patch(path, json={"paused": True}, headers=own).raise_for_status()
    for item in ({"n": 3, **TAG}, {"n": 5, "name": "Ben"}, {"n": 2}):
        view = http.post(path, json={"every": 0.1, **item}, headers=own)
        assert view.status_code == 202, view.text
    assert (view.json()["waiting"], view.json()["paused"]) == (10, True)
    assert dropped(http, room) == [], "it is paused"
    assert http.post(f"{path}/skip", headers=own).json()["waiting"] == 7
    async with playing(server.socket(room)) as player:
        told = await player.until("queue")
        assert (told["waiting"], told["paused"]) == (7, True)
        assert told["items"] == [{"number": 1, "left": 5, "name": "Ben"}, {"number": 2, "left": 2}]
        http.patch(path, json={"paused": False}, headers=own).raise_for_status()
        assert (await player.until("queue", paused=False))["waiting"] == 7
        await player.until("queue", waiting=0, items=[])
        accepted = [each.get("name") for each in player.events if each["type"] == "accepted"]
    assert accepted == ["Ben"] * 5 + [None] * 2
    assert queue_of(http, room) == {"room": room, "paused": False, "waiting": 0, "items": []}
    http.post(path, json={"n": 9, "every": 60}, headers=own)
    assert http.post(f"{path}/clear", headers=own).json()["waiting"] == 0


def test_a_queue_is_its_room_s_owner_s(http: httpx.Client) -> None:
    room, _ = opened(http)
    _, other = opened(http)
    for method, path in (("POST", ""), ("PATCH", ""), ("POST", "/clear"), ("POST", "/skip")):
        for name, shown, status in ((room, {}, 401), (room, other, 403), ("main", other, 403)):
            address = f"/api/v1/rooms/{name}/queue{path}"
            assert http.request(method, address, json={"n": 1}, headers=shown).status_code == status
    assert queue_of(http, "main")["items"] == []


def test_an_invalid_queue_item_is_named_and_a_reset_room_forgets_its_queue(
    http: httpx.Client,
) -> None:
    room, own = opened(http)
    wrong = {"n": (0, MOST_BALLS + 1, "3"), "every": (0.0,), "name": ("<b>",), "colour": ("red",)}
    for field, values in wrong.items():
        for value in values:
            body = {"n": 1, field: value}
            answer = http.post(f"/api/v1/rooms/{room}/queue", json=body, headers=own)
            assert (answer.status_code, answer.json()["field"]) == (422, field)
    http.post(f"/api/v1/rooms/{room}/queue", json={"n": 9, "every": 60}, headers=own)
    http.post(f"/api/v1/rooms/{room}/reset", headers=own).raise_for_status()
    assert queue_of(http, room)["items"] == []


def test_the_queue_s_length_is_limited() -> None:
    full = EMPTY
    for _ in range(MOST_ITEMS):
        full = full.with_item(1, 1.0, NO_TAG)
    with pytest.raises(BallLimitError, match=f"already has {MOST_ITEMS} items"):
        full.with_item(1, 1.0, NO_TAG)
    heavy = EMPTY
    for _ in range(MOST_WAITING // MOST_BALLS):
        heavy = heavy.with_item(MOST_BALLS, 1.0, NO_TAG)
    with pytest.raises(BallLimitError, match=f"n 1: {MOST_WAITING} balls wait already"):
        heavy.with_item(1, 1.0, NO_TAG)
    assert full.skipped().items == full.items[1:]
    assert heavy.cleared().with_item(1, 1.0, NO_TAG).items[0].number == heavy.next


@pytest.mark.long
def test_queued_balls_are_dropped_once_despite_a_restart(tmp_path: Path) -> None:
    """No client asks for the room meanwhile: the queue continues by itself."""
    kept = {"database_url": f"sqlite:///{tmp_path / 'plinko.db'}", "drop_rate": 1000.0}
    count = tries(20, 100)
    with serving(**kept) as server, server.client() as http:
        room, own = opened(http, QUICK)
        path = f"/api/v1/rooms/{room}/queue"
        for name in ("Ada", "Ben"):
            item = {"n": count, "name": name, "every": 0.05}
            http.post(path, json=item, headers=own).raise_for_status()
        live = server.services.rooms.find(room)
        until(lambda: live.room.drops > 5)
    with serving(**kept) as server, server.client() as http:
        rooms = server.services.rooms
        until(lambda: any(live.room.drops == 2 * count for live in rooms.all() if live.id == room))
        until(lambda: queue_of(http, room)["waiting"] == 0)
        order = [ball.get("name") for ball in dropped(http, room)]
    assert order == ["Ada"] * count + ["Ben"] * count


def test_balls_that_wait_are_drops_of_the_address_that_asked(tmp_path: Path) -> None:
    with (
        serving(database_url=f"sqlite:///{tmp_path / 'plinko.db'}", drop_rate=0.1) as server,
        server.client() as http,
    ):
        drops = server.services.room_drops
        drops.rate, drops.burst = 1e-6, 10.0  # no refill while the test runs
        room, own = opened(http)
        path = f"/api/v1/rooms/{room}/queue"
        http.patch(path, json={"paused": True}, headers=own).raise_for_status()
        key = {"idempotency-key": "once"}
        assert http.post(path, json={"n": 8}, headers=own | key).status_code == 202
        again = http.post(path, json={"n": 8}, headers=own | key)
        assert (again.status_code, again.json()["waiting"]) == (202, 8)
        assert '"drops";r=1' in again.headers["ratelimit"], "what is asked for again costs one"
        last = http.post(path, json={"n": 1000}, headers=own)
        assert (last.status_code, last.json()["waiting"]) == (202, 1008)
        for address in (path, f"/api/v1/rooms/{room}/drops"):
            refused = http.post(address, json={"n": 1} if address == path else {}, headers=own)
            assert refused.status_code == 429


class Play:
    """A queue without a room: balls fall until the test calls `land`."""

    def __init__(self) -> None:
        self.dropped: list[int] = []
        self.flying: set[int] = set()
        self.faults: list[Exception] = []
        self.told: list[messages.Event] = []
        self._landing = asyncio.Condition()
        self.queue = RoomQueue(
            Forgetful(), 1, drop=self._drop, flying=lambda: self.flying, landing=self._landed,
            draw=lambda: 7, tell=self.told.append, empty=True,
        )  # fmt: skip

    async def _drop(self, command: DropCommand, player: Player) -> Outcome:
        if self.faults:
            raise self.faults.pop()
        ball = len(self.dropped)
        self.dropped.append(ball)
        self.flying.add(ball)
        return Outcome(
            messages.Accepted(ball=ball, seed=str(command.seed), x=0.0, explicit_x=False, tick=0)
        )

    async def _landed(self) -> None:
        async with self._landing:
            await self._landing.wait()

    async def land(self, ball: int) -> None:
        self.flying.discard(ball)
        async with self._landing:
            self._landing.notify_all()


class Forgetful(NullLedger):
    """A ledger that has no queue of any room."""

    async def read(self, read: object, *args: Any, **values: Any) -> None:  # type: ignore[override]
        return None


async def test_a_queue_goes_on_when_a_ball_lands_and_not_before() -> None:
    play = Play()
    await play.queue.add(MOST_FALLING + 2, 0.0, NO_TAG)
    await eventually(lambda: len(play.dropped) >= MOST_FALLING)
    await turns()
    assert len(play.dropped) == MOST_FALLING, "as many as may fall do"
    await play.land(3)
    await eventually(lambda: len(play.dropped) == MOST_FALLING + 1)
    play.queue.end()
    # An item whose last ball was dropped waits no more.
    play = Play()
    await play.queue.add(1, 60.0, NO_TAG)
    await eventually(lambda: play.dropped)
    assert play.queue.items == []
    assert play.told[-1] == messages.QueueState(waiting=0, paused=False, items=[])
    play.queue.end()


async def test_a_queue_that_fails_says_so_and_tries_the_ball_again(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plinko.app.live.queue._FAILED", 0.0)
    play = Play()
    play.faults = [ZeroDivisionError("a fault of the program")]
    await play.queue.add(2, 0.0, NO_TAG)
    await eventually(lambda: play.queue.waiting == 0)
    assert len(play.dropped) == 2
    assert "a fault of the program" in caplog.text
    play.queue.end()
