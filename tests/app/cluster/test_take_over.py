"""A server takes rooms it was given or whose server is gone, and gives up those it has lost."""

import asyncio
from typing import cast

import pytest

from app.cluster.alive import Alive
from app.cluster.beats import Beats
from app.cluster.membership import LEASE, Look, Member, Seen
from app.cluster.take_over import TakeOver
from app.errors import LeaseLostError
from tests.app.persistence import postgres
from tests.app.persistence.crash.life import BOARD, Life, living
from tests.app.persistence.test_sharing import Watcher
from tests.waiting import LIMIT, eventually

pytestmark = pytest.mark.postgresql


@pytest.fixture
def address(postgresql: postgres.Cluster) -> str:
    return postgresql.new_database()


def looking(life: Life, *others: str) -> tuple[TakeOver, Alive]:
    """What takes rooms over at a server that has seen these others for a lease."""
    book = life.shared.leases.book
    alive = Alive(cast(Beats, object()), book, book.holder)
    members = [Member(name, name, f"http://{name}") for name in (book.holder, *others)]
    found = tuple(Seen(each, 0.0, connected=True) for each in members)
    for now in (0.0, LEASE / 2, LEASE):
        alive.view.look(now, Look(1, found))
    return TakeOver(alive, life.shared, life.ledger, clock=lambda: 0.0), alive


def has(life: Life, room_id: str) -> bool:
    return life.shared.leases.book.of(room_id) is not None


async def test_a_room_that_moves_and_was_given_to_a_server_goes_on_there_unasked(
    address: str,
) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room = await a.rooms.create(BOARD)
        await a.drop(room, 3)
        taking, _ = looking(b, "a")
        leaving = asyncio.create_task(a.shared.leaving.hand_over(room.id, holder="b"))
        await a.until(leaving.done, 1)
        await leaving
        await taking.look()
        await eventually(lambda: has(b, room.id))
        assert taking.count == 0, "nobody was gone"
        await taking.close()


async def test_a_room_whose_server_is_gone_is_taken_over_and_counted(address: str) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room = await a.rooms.create(BOARD)
        taking, _ = looking(b, "a")
        await taking.look()
        await taking.close()
        assert not has(b, room.id), "its server lives"
        taking, _ = looking(b)
        await taking.look()
        await eventually(lambda: has(b, room.id) and taking.count)
        await taking.close()


async def test_who_watches_a_room_that_sleeps_is_sent_on_once_another_server_took_it(
    address: str,
) -> None:
    async with living(address, holder="a") as a, living(address, holder="b") as b:
        room, kept = [await a.rooms.create(BOARD) for _ in range(2)]
        watching, staying = Watcher(a, room.id), Watcher(a, kept.id)
        await b.shared.arriving.take_over(room.id)
        taking, _ = looking(a, "b")
        await taking.look()
        with pytest.raises(LeaseLostError):
            await asyncio.wait_for(watching.running, LIMIT)
        assert not staying.running.done()
        assert (has(a, room.id), has(a, kept.id)) == (False, True)
        staying.running.cancel()
        await taking.close()
