"""When there are too many rooms, the server closes those unused for longest, and no others."""

import pytest

from plinko.app.errors import RoomLimitError
from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.registry import Rooms
from plinko.app.persistence.service import PersistenceService
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import BallLimits
from plinko.app.settings import Settings
from plinko.engine import Board
from tests.app.live.test_registry import Watcher
from tests.app.passes import RoomsByHand
from tests.kit.null_ledger import NullLedger

BOARD = Board.preset("triangle-8")


class Clock:
    """Unix time that the test sets."""

    now = 1e9

    def __call__(self) -> float:
        return self.now


def held_by(clock: Clock, **settings: float) -> Rooms:
    chosen = Settings(**settings)  # type: ignore[arg-type]
    service = PersistenceService(NullLedger(), tick_rate=60, limits=BallLimits(8, 8), now=clock)
    return RoomsByHand(chosen, Boards(8), Hub(8), BOARD, service)


async def test_newcomers_do_not_close_a_room_that_was_used_lately() -> None:
    clock = Clock()
    held = held_by(clock, max_rooms=3)
    mine = [(await held.create(BOARD)).id for _ in range(3)]
    clock.now += 3599
    for _ in range(100):
        with pytest.raises(RoomLimitError, match="all 3 rooms are in use"):
            await held.create(BOARD)
    assert all(map(held.is_open, mine))


async def test_the_longest_unused_makes_way_once_it_has_rested() -> None:
    clock = Clock()
    held = held_by(clock, max_rooms=2)
    first, second = [(await held.create(BOARD)).id for _ in range(2)]
    clock.now += 3000
    held.find(first)  # its owner uses it
    clock.now += 700
    await held.create(BOARD)
    assert (held.is_open(first), held.is_open(second)) == (True, False)
    with pytest.raises(RoomLimitError):
        await held.create(BOARD)


async def test_a_recently_watched_room_is_not_closed() -> None:
    clock = Clock()
    held = held_by(clock, max_rooms=2)
    watched, other = [await held.create(BOARD) for _ in range(2)]
    viewer = Watcher().client
    held.enter(watched, viewer)
    clock.now += 3000
    held.find(other.id)
    clock.now += 3000
    held.exit(watched, viewer)
    clock.now += 3601
    await held.create(BOARD)
    assert (held.is_open(watched.id), held.is_open(other.id)) == (True, False)


async def test_a_request_for_one_room_counts_no_other_s_clients(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    held = held_by(Clock(), max_rooms=20)
    mine = [await held.create(BOARD) for _ in range(20)]
    asked: list[str] = []

    def count(room_id: str, stream: str | None = None) -> int:
        asked.append(room_id)
        return 0

    monkeypatch.setattr(held.hub, "count", count)
    await held.seek(mine[0].id)
    assert not asked


async def test_everybodys_rooms_open_however_many_rooms_players_have() -> None:
    held = held_by(Clock(), max_rooms=1)
    mine = await held.create(BOARD)
    assert held.free == 0
    for name in ("main", "triangle-9", "classic", "sandbox", "interacting-triangle-8"):
        assert held.find(name).id == name
    assert held.is_open(mine.id)


async def test_a_room_used_in_the_last_minute_stays_in_memory(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its creator's first drop may be under way when others fill the memory."""
    monkeypatch.setattr("plinko.app.live.open_rooms._IN_MEMORY", 2)
    clock = Clock()
    service = PersistenceService(NullLedger(), tick_rate=60, limits=BallLimits(8, 8), now=clock)
    held = Rooms(Settings(), Boards(8), Hub(8), BOARD, service)
    unused, used, *others = [(await held.create(BOARD)).id for _ in range(5)]
    assert all(map(held.find, (unused, used, *others)))
    clock.now += 59.0
    held.find(used)
    clock.now += 2.0
    newest = (await held.create(BOARD)).id
    assert set(held._open.in_memory) == {used, newest}
