"""After a restart the rooms are as before, every promise is kept, and the start is short."""

import asyncio
import json
import logging
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from plinko.app.errors import AppError, DamagedRoomError
from plinko.app.live.live_room import LiveRoom
from plinko.app.persistence import room_runs
from plinko.app.persistence.room_log import RoomLogs
from plinko.app.persistence.statements import store
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.kinds import INDEPENDENT, INTERACTING
from plinko.app.rooms.log import verify_log
from plinko.app.rooms.records import DropRow, ResultRow
from plinko.app.rooms.stakes import payout_of
from plinko.engine import PHYSICS_VERSION, Board, drop
from tests.app.persistence.conftest import on_sqlite
from tests.app.persistence.crash.life import (
    BOARD,
    CLOCK,
    Life,
    break_page,
    change,
    copy_ledger,
    living,
    look,
)
from tests.kit.player import playing
from tests.kit.serving import serving
from tests.kit.waiting import eventually, until

OTHER = Board.preset("triangle-9")


async def busy(life: Life, live: LiveRoom, seeds: range, ticks: int = 20) -> None:
    """Drop balls one after another, and tick some more."""
    for seed in seeds:
        await life.drop(live, seed, stake=100 + seed)
    await life.run(live, ticks)


def kept(url: str, session: int) -> list[tuple[DropRow, ResultRow | None]]:
    found: list[tuple[DropRow, ResultRow | None]] = look(url, store.drops, session, 0)
    return found


# Rooms of touching balls.


@pytest.mark.parametrize("orderly", [True, False])
@on_sqlite
async def test_an_empty_touching_room_comes_back_and_takes_a_ball(url: str, orderly: bool) -> None:
    name = "interacting-triangle-8"
    async with living(url) as life:
        room = await life.rooms.seek(name)
        await life.drop(room, 1)
        await life.rest()
        was = room.room.world.digest
        if orderly:
            await life.leave()
    async with living(url) as life:
        room = await life.rooms.seek(name)
        assert (room.room.world.count, room.room.input_count, room.room.world.digest) == (0, 1, was)
        await life.drop(room, 2)
        await life.rest()
        assert room.room.stats().drops == 2


# Promises.


async def test_drops_that_another_physics_cannot_land_are_refunded(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room_runs, "PHYSICS_VERSION", PHYSICS_VERSION - 1)
    async with living(url) as life:
        own = await life.rooms.create(BOARD, INDEPENDENT)
        await busy(life, own, range(4))
        numbers = {
            room.id: life.rooms.persistence.runs.of(room.room).number
            for room in (own, life.rooms.find("main"))
        }
        await busy(life, life.rooms.find("main"), range(3))
        await life.leave()
    monkeypatch.undo()
    async with living(url) as life:
        await life.back()
        again = await life.rooms.seek(own.id)
        assert again.owned, "its token still permits changes"
        assert (again.room.world.tick, again.room.input_count) == (0, 0), "it starts again"
        assert (await life.row(own.id)).physics_version == PHYSICS_VERSION
        assert life.rooms.find("main").room.input_count == 0
        assert (await life.drop(again, 9, stake=5)).ball == 0
    for number in numbers.values():
        drops = kept(url, number)
        assert drops
        for row, result in drops:
            assert result is not None
            assert (result.payout, result.bin) == (row.stake, None)
            assert "physics version is" in str(result.unsettled)


@on_sqlite
async def test_main_with_another_board_lands_its_balls_and_restarts(url: str) -> None:
    async with living(url) as life:
        main = life.rooms.find("main")
        await busy(life, main, range(3))
        number = life.rooms.persistence.runs.of(main.room).number
    async with living(url, board=OTHER) as life:
        main = await life.rooms.seek("main")
        assert (main.room.origin.digest, main.room.input_count) == (OTHER.digest, 0)
        await life.drop(main, 1)
    assert all(result is not None and result.digest for _, result in kept(url, number))


@on_sqlite
async def test_a_ball_long_in_flight_is_refunded_whatever_came_after(
    url: str,
) -> None:
    """Recovery considers more than the last `max_balls` drops."""
    async with living(url) as life:
        main = life.rooms.find("main")
        await busy(life, main, range(6), 600)
        await busy(life, main, range(6, 9))
        number = life.rooms.persistence.runs.of(main.room).number
        await life.leave()
    change(
        url,
        f"DELETE FROM results WHERE room = {number} AND ball = 0",
        "UPDATE rooms SET physics_version = physics_version - 1",
    )
    async with living(url, max_balls=2) as life:
        await life.back()
    first = kept(url, number)[0]
    assert first[1] is not None
    assert first[1].payout == first[0].stake


# Time.


@on_sqlite
async def test_a_start_loads_main_only_and_each_room_when_it_is_asked_for(url: str) -> None:
    async with living(url) as life:
        own = await life.rooms.create(BOARD, INDEPENDENT)
        await busy(life, own, range(2))
        await busy(life, life.rooms.find("main"), range(2))
        shown = own.room.world.bodies["x"].tolist()
    async with living(url, go_on=False) as life:
        assert [each.id for each in life.rooms.all()] == ["main"]
        assert own.id in {each.id for each in await life.stored.directory()}
        back = await life.rooms.seek(own.id)
        assert (back.room.input_count, back.room.awake) == (2, True)
        assert back.room.world.bodies["x"].tolist() == shown, "each ball is where it should be"
        await life.drop(await life.rooms.seek("triangle-9"), 1)


@on_sqlite
async def test_balls_that_landed_while_no_server_ran_get_their_results(url: str) -> None:
    async with living(url) as life:
        own = await life.rooms.create(BOARD, INDEPENDENT)
        await busy(life, own, range(3), 1)
        number = life.rooms.persistence.runs.of(own.room).number
    CLOCK.tick(100_000)
    async with living(url) as life:
        await life.back()
        await life.heard()
        room = await life.rooms.seek(own.id)
        assert (room.room.awake, sum(room.room.stats().histogram)) == (False, 3)
        await life.leave()
        await life.heard()
    for row, result in kept(url, number):
        assert result is not None
        assert result.digest == drop(BOARD, row.seed).digest
        assert result.tick < 1000


@on_sqlite
async def test_after_the_clock_was_set_back_a_room_goes_on_after_its_last_drop(url: str) -> None:
    async with living(url) as life:
        main = life.rooms.find("main")
        await busy(life, main, range(3), 100)
        last = (await life.drop(main, 3)).tick
    before = CLOCK.ticks
    try:
        CLOCK.ticks -= 24 * 3600 * 60
        async with living(url) as life:
            main = await life.rooms.seek("main")
            assert main.room.world.tick == last
            assert (await life.drop(main, 4)).tick > last
            await life.rest()
            assert sum(main.room.stats().histogram) == 5
    finally:
        CLOCK.ticks = before


# Damage.

_OWN = "(SELECT number FROM rooms WHERE owned)"
DAMAGES = {
    "a drop is missing": [
        f"DELETE FROM results WHERE room IN {_OWN} AND ball = 1",
        f"DELETE FROM drops WHERE room IN {_OWN} AND ball = 1",
    ],
    "a seed is no number": [f"UPDATE drops SET seed = '0x' WHERE room IN {_OWN} AND ball = 1"],
    "a start off the board": [f"UPDATE drops SET x = 1e9 WHERE room IN {_OWN} AND ball = 5"],
    "a tick that never was": [
        f"UPDATE drops SET tick = 1152921504606846976 WHERE room IN {_OWN} AND ball = 5"
    ],
    "a board": [
        "UPDATE boards SET json = replace(json, 'gravity', 'GRAVITY')"
        " WHERE digest IN (SELECT board FROM rooms WHERE owned)"
    ],
}


@dataclass(frozen=True)
class Played:
    """The ledger of a killed server: a private room and `main`, both with balls in flight."""

    file: Path
    own: str


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Played:
    file = tmp_path_factory.mktemp("played") / "plinko.db"

    async def play() -> str:
        async with living(f"sqlite:///{file}") as life:
            own = await life.rooms.create(OTHER, INDEPENDENT)
            await busy(life, life.rooms.find("main"), range(3), 1)
            for seed in range(6):
                await busy(life, own, range(seed, seed + 1), 50)
            assert own.room.stats().drops > own.room.world.count, "some have landed"
            return own.id

    return Played(file, asyncio.run(play()))


@pytest.mark.parametrize("name", DAMAGES)
async def test_one_damaged_room_is_set_aside_and_the_rest_play(
    played: Played, tmp_path: Path, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    url = f"sqlite:///{copy_ledger(played.file, tmp_path)}"
    change(url, *DAMAGES[name])
    rows = look(url, store.open_room, played.own)
    with caplog.at_level(logging.ERROR):
        async with living(url) as life:
            await life.back()
            for _ in range(2):
                with pytest.raises(DamagedRoomError, match=f"room '{played.own}' is unavailable"):
                    await life.rooms.seek(played.own)
            assert list(life.rooms.persistence.recovery.set_aside) == [played.own]
            main = await life.rooms.seek("main")
            assert (main.room.input_count, (await life.drop(main, 1)).ball) == (3, 3)
            await life.leave()
    (line,) = [each for each in caplog.records if each.levelno == logging.ERROR]
    assert vars(line)["room"] == played.own
    assert look(url, store.open_room, played.own) == rows, "nothing of it was changed"


async def test_a_sleeping_damaged_room_is_set_aside_when_asked_for(url: str) -> None:
    names = ("interacting-triangle-8",)
    async with living(url) as life:
        own = await life.rooms.create(BOARD, INTERACTING)
        for room in (own, *[await life.rooms.seek(name) for name in names]):
            await life.drop(room, 1)
        await life.rest()
        await life.leave()
    change(url, "UPDATE rooms SET checkpoint_drops = 7")
    async with living(url) as life:
        for room_id in (own.id, *names, *names):
            with pytest.raises(DamagedRoomError, match="its record is damaged"):
                await life.rooms.seek(room_id)
        assert set(life.rooms.persistence.recovery.set_aside) == {own.id, *names}
        await life.drop(await life.rooms.seek("triangle-9"), 1)
    change(url, "UPDATE rooms SET checkpoint_drops = 1 WHERE checkpoint_drops = 7")
    async with living(url) as life:
        for room_id in (own.id, *names):
            assert (await life.drop(await life.rooms.seek(room_id), 2)).tick > 0, "once mended"


async def test_a_damaged_list_of_rooms_refuses_the_start(played: Played, tmp_path: Path) -> None:
    file = copy_ledger(played.file, tmp_path)
    break_page(file, "rooms")
    with pytest.raises(DamagedRoomError, match="list of rooms is damaged: restore a backup"):
        async with living(f"sqlite:///{file}"):
            pass


@on_sqlite
@pytest.mark.parametrize("bug", ["step", "enter", "result"])
async def test_drops_of_a_room_that_failed_are_paid_as_their_flights_say(
    url: str, bug: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The third fact's ball is in flight or could not enter. Who cannot land pays back."""
    async with living(url) as life:
        room = await life.rooms.create(BOARD, INDEPENDENT)
        await life.drop(room, 1, stake=100)
        await life.rest()
        await life.drop(room, 2, stake=200)
        number = life.rooms.persistence.runs.of(room.room).number

        assert isinstance(room.room, IndependentRoom)
        land = type(room.room).result

        def fail(*_: object, **__: object) -> None:
            raise ZeroDivisionError("a bug")

        if bug == "enter":
            monkeypatch.setattr(type(room.room), bug, fail)
            with pytest.raises(AppError, match="failed and was closed"):
                await life.drop(room, 3, stake=300)
        else:
            await life.drop(room, 3, stake=300)
            monkeypatch.setattr(type(room.room.world), "step", fail)
            monkeypatch.setattr(type(room.room), "result", fail if bug == "result" else land)
            life.tick(1)
        assert not life.rooms.is_open(room.id)
        await life.leave()
    monkeypatch.undo()
    drops = kept(url, number)
    assert [row.seed for row, _ in drops] == [1, 2, 3]
    for row, result in drops:
        assert result is not None
        if bug == "result" and row.seed != 1:
            assert (result.bin, result.digest, result.payout) == (None, "", row.stake)
            assert result.unsettled == "its room failed"
        else:
            flown = drop(BOARD, row.seed)
            assert (result.bin, result.digest, result.unsettled) == (flown.bin, flown.digest, None)
            assert result.payout == payout_of(row.stake, flown.score)
    async with living(url) as life:
        logs = RoomLogs(life.rooms.persistence.runs)
        found = await life.rooms.persistence.recovery.closed(room.id)
        assert found is not None
        pieces = await logs.read(found[1], "", marks=True, run=found[0])
        log = json.loads(b"".join([piece async for piece in pieces]))
        assert [each["result"]["payout"] for each in log["drops"]] == [
            result.payout for _, result in drops if result is not None
        ]
        assert verify_log(log).ok
        log["drops"][2]["result"]["payout"] += 1
        assert verify_log(log).field == "drops[2].result.payout"


@on_sqlite
async def test_a_cancelled_request_leaves_no_half_made_room(url: str) -> None:
    async with living(url) as life:
        kept_rooms = await life.rooms.create(BOARD, INDEPENDENT)
        gone = [
            asyncio.create_task(life.rooms.create(BOARD, INDEPENDENT)),
            asyncio.create_task(life.rooms.delete(kept_rooms)),
        ]
        await asyncio.sleep(0)
        for each in gone:
            each.cancel()
        await asyncio.gather(*gone, return_exceptions=True)
        await life.heard()

        def owned() -> list[str]:
            return [room.id for room in life.rooms.all() if room.owned]

        await eventually(lambda: kept_rooms.id not in owned() and owned())
        (made,) = owned()
        await life.leave()
    assert look(url, store.open_room, made) is not None
    assert look(url, store.open_room, kept_rooms.id) is None


@on_sqlite
async def test_a_moved_room_asked_for_by_many_comes_back_once(url: str) -> None:
    async with living(url) as life:
        await busy(life, life.rooms.find("main"), range(3))
    async with living(url) as life:
        found: list[Any] = await asyncio.gather(*(life.rooms.seek("main") for _ in range(9)))
        assert {id(room) for room in found} == {id(life.rooms.find("main"))}


async def test_a_damaged_room_is_reported_to_clients_and_operators(
    played: Played, tmp_path: Path
) -> None:
    file = copy_ledger(played.file, tmp_path)
    lately = f"UPDATE rooms SET used = {time.time()}"  # or it would be closed as unused
    change(f"sqlite:///{file}", *DAMAGES["a seed is no number"], lately)
    break_page(file, "inputs")
    with (
        serving(database_url=f"sqlite:///{file}") as server,
        server.client() as http,
    ):
        until(lambda: server.services.integrity.finding != "checking")
        refused = http.get(f"/api/v1/rooms/{played.own}")
        assert (refused.status_code, refused.json()["code"]) == (503, "room-damaged")
        assert "the server's operator can repair it" in refused.json()["detail"]
        assert refused.headers["retry-after"] == "60"
        async with playing(server.socket(played.own)) as player:
            assert (player.hello["type"], player.hello["code"]) == ("error", "room-damaged")
            with pytest.raises(ConnectionClosed) as closed:
                await player.step()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1013
        assert http.post("/api/v1/rooms/main/drops?wait=1").status_code == 200
        ready = http.get("/readyz")
        assert (ready.status_code, ready.json()["ready"]) == (200, True)
        assert ready.json()["rooms"] == {"set_aside": [played.own]}
        assert ready.json()["integrity"] == "damaged"
        readings = http.get("/metrics").text.splitlines()
        assert {"plinko_rooms_set_aside 1.0", "plinko_ledger_sound 0.0"} <= set(readings)
