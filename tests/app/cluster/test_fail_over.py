"""A server takes rooms given to it or left by a failed server, and gives up those it lost."""

import asyncio
import contextlib
import itertools

import pytest

from plinko.app.cluster.alive import Alive
from plinko.app.cluster.fail_over import FailOver
from plinko.app.cluster.membership import LEASE, Member, Seen, order
from plinko.app.errors import LeaseLostError, LedgerError
from tests.app.persistence.crash.life import BOARD, Life, living
from tests.app.persistence.test_sharing import Watcher
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import LIMIT

C = Member("c", "c", "")

pytestmark = pytest.mark.postgresql


@pytest.fixture
def address(postgresql: PostgreSQL) -> str:
    return postgresql.new_database()


def looking(life: Life, *others: str) -> FailOver:
    """The take-over of a server that has seen these others for the length of a lease."""
    book = life.leases.book
    alive = Alive("", book, book.holder)
    found = [Seen(Member(name, name, ""), LEASE / 2, connected=True) for name in others]
    for _ in range(3):
        alive.look(alive.me, [Seen(alive.me, LEASE / 2, connected=True), *found])
    return FailOver(alive, life.stored, life.ledger, clock=itertools.count(0.0, 2.0).__next__)


async def taken(life: Life, taking: FailOver) -> set[str]:
    """Poll once and take the rooms found, with retries while PostgreSQL is busy."""
    async with asyncio.timeout(LIMIT):
        due: set[str] | None = None
        while due is None:
            with contextlib.suppress(LedgerError):
                due = await taking.look()
        for room_id in due:
            while not has(life, room_id):
                await taking.take(room_id)
    return due


def has(life: Life, room_id: str) -> bool:
    return life.leases.book.of(room_id) is not None


async def test_a_moving_room_given_to_a_server_goes_on_there_unasked(
    address: str,
) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room = await a.rooms.create(BOARD)
        await a.drop(room, 3)
        taking = looking(b, "a")
        leaving = asyncio.create_task(a.stored.leaving.migrate(room.id, holder="b"))
        await a.until(leaving.done, 1)
        await leaving
        assert await taken(b, taking) == {room.id}
        assert has(b, room.id)
        assert taking.count == 0, "nobody was gone"


async def test_a_room_whose_server_is_gone_is_taken_over_and_counted(address: str) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room = await a.rooms.create(BOARD)
        await taken(b, looking(b, "a"))
        assert not has(b, room.id), "its server lives"
        taking = looking(b)
        assert room.id in await taken(b, taking)
        assert has(b, room.id)
        assert taking.count >= 1


async def test_a_room_without_a_server_is_taken_but_not_counted(address: str) -> None:
    async with living(address, holder="a") as a:
        taking = looking(a)
        assert await taken(a, taking) == {"main"}
        assert taking.count == 0, "it is the first start of all"


async def test_a_room_whose_heir_cannot_take_it_goes_to_the_next(
    address: str,
) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        mine = looking(b, "c")  # c lives, but takes nothing
        rooms = [(await a.rooms.create(BOARD)).id for _ in range(8)]
        of_c = {each for each in rooms if order(each, [Member("b", "b", ""), C])[0] == C}
        assert not of_c & await taken(b, mine), "it is c's turn"
        assert of_c <= await taken(b, mine)
        assert all(has(b, each) for each in rooms)


async def test_viewers_of_a_sleeping_room_are_sent_on_once_it_is_taken(
    address: str,
) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room, kept = [await a.rooms.create(BOARD) for _ in range(2)]
        watching, staying = Watcher(a, room.id), Watcher(a, kept.id)
        await b.stored.arriving.take(room.id)
        await taken(a, looking(a, "b"))
        with pytest.raises(LeaseLostError):
            await asyncio.wait_for(watching.running, LIMIT)
        assert not staying.running.done()
        assert (has(a, room.id), has(a, kept.id)) == (False, True)
        staying.running.cancel()
