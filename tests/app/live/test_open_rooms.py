"""When there are too many rooms, the server closes those unused for longest, and no others."""

import pytest

from plinko.app.errors import RoomLimitError, UnknownRoomError
from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.registry import Rooms
from plinko.app.persistence.service import PersistenceService
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import BallLimits
from plinko.app.settings import TICK_RATE, Settings
from plinko.engine import Board
from tests.app.live.test_registry import Watcher
from tests.app.persistence.crash.life import CLOCK, living
from tests.kit.null_ledger import NullLedger

BOARD = Board.preset("triangle-8")


def pass_time(seconds: int) -> None:
    CLOCK.tick(TICK_RATE * seconds)


async def is_open(rooms: Rooms, live: LiveRoom) -> bool:
    try:
        await rooms.seek(live.id)
    except UnknownRoomError:
        return False
    return True


async def test_the_longest_unused_makes_way_once_it_has_rested() -> None:
    async with living("sqlite://", max_rooms=2) as life:
        first, second = [await life.rooms.create(BOARD) for _ in range(2)]
        pass_time(3000)
        life.rooms.find(first.id)  # its owner uses it
        pass_time(700)
        await life.rooms.create(BOARD)
        with pytest.raises(RoomLimitError):
            await life.rooms.create(BOARD)
        opened = [await is_open(life.rooms, each) for each in (first, second)]
        assert opened == [True, False]


async def test_newcomers_close_the_longest_unused_room_and_none_that_was_used_lately() -> None:
    async with living("sqlite://", max_rooms=3) as life:
        mine = []
        for _ in range(3):
            mine.append(await life.rooms.create(BOARD))
            pass_time(1)
        pass_time(3596)
        for _ in range(10):
            with pytest.raises(RoomLimitError, match="all 3 rooms are in use"):
                await life.rooms.create(BOARD)
        assert [await is_open(life.rooms, each) for each in mine] == [True] * 3
        for room in mine[1:]:
            life.rooms.find(room.id)
            pass_time(1)
        life.rooms.find(mine[0].id)
        pass_time(7200)
        await life.rooms.create(BOARD)
        opened = [await is_open(life.rooms, each) for each in mine]
        assert opened == [True, False, True]


async def test_a_recently_watched_room_is_not_closed() -> None:
    async with living("sqlite://", max_rooms=2) as life:
        watched, other = [await life.rooms.create(BOARD) for _ in range(2)]
        viewer = Watcher().client
        life.rooms.enter(watched, viewer)
        pass_time(3000)
        life.rooms.find(other.id)
        pass_time(3000)
        life.rooms.exit(watched, viewer)
        pass_time(3601)
        await life.rooms.create(BOARD)
        opened = [await is_open(life.rooms, each) for each in (watched, other)]
        assert opened == [True, False]


async def test_everybodys_rooms_open_however_many_rooms_players_have() -> None:
    async with living("sqlite://", max_rooms=1) as life:
        await life.rooms.create(BOARD)
        assert await life.stored.free() == 0
        for name in ("main", "triangle-9", "classic", "sandbox", "interacting-triangle-8"):
            assert (await life.rooms.seek(name)).id == name


async def test_a_room_used_in_the_last_minute_stays_in_memory(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its creator's first drop may be under way when others fill the memory."""
    monkeypatch.setattr("plinko.app.live.open_rooms._IN_MEMORY", 2)
    now = 1e9
    service = PersistenceService(NullLedger(), limits=BallLimits(8, 8), now=lambda: now)
    held = Rooms(Settings(), Boards(8), Hub(8), BOARD, service)
    unused, used, *others = [(await held.create(BOARD)).id for _ in range(5)]
    assert all(map(held.find, (unused, used, *others)))
    now += 59.0
    held.find(used)
    now += 2.0
    newest = (await held.create(BOARD)).id
    assert {live.id for live in held.all()} == {used, newest}
