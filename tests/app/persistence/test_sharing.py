"""Rooms in a ledger that several servers share are taken over and handed over unchanged."""

import asyncio
import contextlib
import hashlib
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

import msgspec
import pytest
import sqlalchemy as sa

from plinko.app.errors import (
    AppError,
    HaltedError,
    LeaseLostError,
    LedgerError,
    RoomLimitError,
    UnknownRoomError,
)
from plinko.app.fairness.check import check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.fairness.signing import Signer
from plinko.app.live.arriving import Claim, any_room
from plinko.app.live.broadcast.hub import Client, Mailbox
from plinko.app.live.orders import HALT, RELEASE
from plinko.app.live.sessions.fair_sessions import FairSessions
from plinko.app.live.stored_rooms import UNUSED_SECONDS
from plinko.app.persistence.checks.audit import Audit
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.signing_key import SigningKey
from plinko.app.persistence.statements import lease_store, store, tables
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.kinds import INTERACTING
from plinko.app.rooms.records import EVERY_ROOM, LeaseRow
from tests.app.asking import ask
from tests.app.persistence.crash.life import BOARD, CLOCK, Life, living
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import LIMIT, eventually, turns

KERNEL = kernel_digest_of(b"kernels")
SECRET = b"\x2a" * 32


@pytest.fixture
def address(postgresql: PostgreSQL) -> str:
    return postgresql.new_database()


@contextlib.asynccontextmanager
async def two(
    address: str, *, claim: Claim = any_room, **settings: Any
) -> AsyncIterator[tuple[Life, Life]]:
    """Two servers that share a ledger; `claim` is the second one's."""
    async with (
        living(address, holder="a", **settings) as a,
        living(address, holder="b", claim=claim, **settings) as b,
    ):
        yield a, b


def sound(address: str) -> Audit:
    """Check a ledger that no server uses; returns the audit."""
    audit, database = Audit(), Database(address)
    database.open()
    with database.transaction() as connection:
        numbers = store.run_numbers(connection)
    for number in numbers:
        audit.look(database, number, replay=True)
    database.close()
    assert audit.findings == []
    return audit


class Watcher:
    """A client that records the messages sent to it."""

    def __init__(self, life: Life, room_id: str) -> None:
        self.heard: list[bytes] = []
        self.client = Client(1, self, Mailbox(1000, 1 << 20), 60.0)
        self.running = asyncio.create_task(self.client.run())
        life.rooms.enter(life.rooms.find(room_id), self.client)

    def write(self, wire: bytes) -> bool:
        self.heard.append(wire)
        return True

    async def send(self, message: WireMessage) -> None:
        self.heard.append(message.payload)


async def test_a_room_goes_on_at_the_server_that_takes_it_over(address: str) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        for seed in range(5):
            await a.drop(room, seed)
        await a.run(room, 20)
        shown = room.room.world.tick
        taken = await b.stored.arriving.take("main")
        assert taken is not None
        assert (taken.room.input_count, taken.room.world.count) == (5, room.room.world.count)
        assert taken.room.world.tick == shown, "spectators see no jump"
        await b.run(taken, 20)
        room.room.advance(taken.room.world.tick)  # as if it had stayed at its server
        assert taken.room.world.digest == room.room.world.digest
        await b.rest()
        await b.leave()
    assert (sound(address).drops, sound(address).results) == (5, 5)


async def test_a_room_that_another_server_took_is_logged_once(
    address: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        await b.stored.arriving.take("main")
        asking = [ask(room, seed) for seed in range(3)]
        await turns()
        for each in asking:
            each.cancel()
        await a.heard()
        await eventually(lambda: room.gone is not None)
        await turns()
    (line,) = [each for each in caplog.records if each.levelname == "WARNING"]
    assert (line.getMessage(), vars(line)["room"]) == ("another server has taken a room", "main")


async def test_a_server_that_wakes_up_shows_what_its_successor_shows(address: str) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        await a.drop(room, 7)
        taken = await b.stored.arriving.take("main")
        assert taken is not None
        a.tick(100)  # a process that wakes up ticks before it notices the loss
        b.tick(1)
        room.room.advance(taken.room.world.tick)
        assert room.room.world.digest == taken.room.world.digest


async def test_a_client_of_a_server_that_wakes_up_sees_no_earlier_tick_at_its_successor(
    address: str,
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        await a.drop(room, 7)
        b.tick(1000)  # meanwhile the ball lands
        taken = await b.stored.arriving.take("main")
        assert taken is not None
        assert not taken.awake
        b.tick(100)
        a.tick(1)
        watcher = Watcher(b, "main")
        await eventually(lambda: watcher.heard)
        _, brace, rest = watcher.heard[0].partition(b"{")  # after the header of the frame
        hello = msgspec.json.decode(brace + rest)
        assert hello["tick"] >= room.room.world.tick


async def test_clients_of_a_lost_room_are_disconnected_at_once(address: str) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        await a.drop(room, 7)
        watcher = Watcher(a, "main")
        await b.stored.arriving.take("main")
        waiting = asyncio.create_task(room.landings.wait(0, 60.0))
        await turns()
        asked = ask(room, 8, client=1)
        await turns()
        heard = len(watcher.heard)
        with pytest.raises(LeaseLostError, match="at another server"):
            await watcher.running
        with pytest.raises(LeaseLostError):
            await asked
        assert await waiting is None  # accepted; the ball lands at the other server
        assert watcher.heard[heard:] == []
        assert (a.rooms.all(), a.leases.book.rooms, a.rooms.runner.awake) == ([], [], [])
        with pytest.raises(LeaseLostError):
            a.rooms.find("main")
        a.tick(100)
        await a.heard()
        assert (await b.row("main")).id == "main"
        back = await a.rooms.seek("main")  # the first server can take the room again
        assert back.room.input_count == 1


def not_a_s(room_id: str, row: LeaseRow | None) -> int | None:
    """The cluster's claim while server `a` is alive: only rooms that `a` does not lease."""
    if row is not None and row.holder == "a":
        raise LeaseLostError(f"{room_id} is at a", holder="a")
    return None


async def test_a_lost_room_cannot_be_joined_at_its_former_server(address: str) -> None:
    async with two(address, claim=not_a_s) as (a, b):
        room = await b.rooms.seek("main")
        await b.drop(room, 7)
        moved = await a.stored.arriving.take("main")
        assert moved is not None
        await a.run(moved, 30)
        with pytest.raises(LeaseLostError, match="main is at a") as found:
            await b.rooms.seek("main")
        assert found.value.holder == "a"
        assert b.rooms.all() == []


async def test_a_room_is_handed_over_without_a_tick_in_between(address: str) -> None:
    async with two(address) as (a, b):
        for mode in ("independent", INTERACTING):
            room, begun = await a.rooms.create(BOARD, mode), CLOCK.ticks
            await a.drop(room, 3)
            asked = ask(room, 4)
            await turns()
            leaving = asyncio.create_task(a.stored.leaving.migrate(room.id))
            await turns()
            with pytest.raises(LeaseLostError):
                await ask(room, 5)
            while not leaving.done():
                a.tick(1)
                await asyncio.sleep(0)
            await leaving
            accepted = await asked  # answered before the room leaves
            assert accepted.ball == 1
            at = room.room.world.tick
            assert await a.ledger.read(lease_store.holder_of, room=room.id) is not None
            taken = await b.rooms.seek(room.id)
            assert taken.room.world.tick == CLOCK.ticks - begun if mode != INTERACTING else at
            assert taken.room.input_count == room.room.input_count
            room.room.advance(taken.room.world.tick)
            assert taken.room.world.digest == room.room.world.digest
        await b.rest()
        await b.leave()
    assert sound(address).sessions == 2


async def test_viewers_are_sent_on_only_when_the_next_server_is_ready(address: str) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.create(BOARD)
        await a.drop(room, 3)
        watcher = Watcher(a, room.id)
        taken = []

        async def receive() -> None:
            taken.append(await b.rooms.seek(room.id))
            await turns()
            assert not watcher.running.done()
            with pytest.raises(LeaseLostError):
                a.rooms.find(room.id)  # requests meanwhile find no room

        await a.stored.leaving.migrate(room.id, receive)
        assert [each.room.world.tick for each in taken] == [room.room.world.tick]
        with pytest.raises(LeaseLostError):
            await watcher.running
        a.stored.leaving.check(room.id)  # it has left


async def test_viewers_are_sent_on_even_if_the_next_server_failed(
    address: str,
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.create(BOARD)
        watcher = Watcher(a, room.id)

        async def receive() -> None:
            raise AppError("it does not answer")

        with pytest.raises(AppError, match="does not answer"):
            await a.stored.leaving.migrate(room.id, receive)
        with pytest.raises(LeaseLostError):
            await watcher.running
        assert (await b.rooms.seek(room.id)).id == room.id


async def test_a_claim_that_is_refused_brings_nothing_here(address: str) -> None:
    async with two(address, claim=not_a_s) as (a, b):
        await a.rooms.seek("main")
        with pytest.raises(LeaseLostError, match="main is at a"):
            await b.rooms.seek("main")
        with pytest.raises(UnknownRoomError):
            await b.rooms.seek("nowhere")
        assert a.leases.book.rooms == ["main"]
        assert [row.holder for row in await b.ledger.read(lease_store.listing)] == ["a"]


async def test_a_room_is_handed_to_one_server_and_none_comes_between(
    address: str,
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.create(BOARD)
        await a.stored.leaving.migrate(room.id, holder="b", address="http://b")
        row = await a.ledger.read(lease_store.holder_of, room=room.id)
        assert row is not None
        assert (row.holder, row.address) == ("b", "http://b")
        assert (await b.rooms.seek(room.id)).id == room.id
        lease = b.leases.book.of(room.id)
        assert lease is not None
        assert lease.number == row.number + 1


async def test_hundreds_of_simultaneous_seeks_cost_one_query(
    address: str,
) -> None:
    looks = []

    def count(room_id: str, row: LeaseRow | None) -> int | None:
        looks.append(room_id)
        return not_a_s(room_id, row)

    async with two(address, claim=count) as (a, b):
        await a.rooms.seek("main")
        asking = [asyncio.create_task(b.rooms.seek("main")) for _ in range(300)]
        await turns()
        asking[0].cancel()  # must not cancel the other caller's answer
        found = await asyncio.gather(*asking[1:], return_exceptions=True)
        assert {type(each) for each in found} == {LeaseLostError}
        assert looks == ["main"]
        with pytest.raises(LeaseLostError):
            await b.rooms.seek("main")
        assert looks == ["main"] * 2, "a later client receives the state of then"


async def test_a_client_of_a_leaving_room_waits_until_it_is_there(address: str) -> None:
    async with two(address, claim=not_a_s) as (a, b):
        room = await b.rooms.create(BOARD)
        arrived = asyncio.Event()
        leaving = asyncio.create_task(b.stored.leaving.migrate(room.id, arrived.wait, holder="a"))
        await eventually(lambda: b.rooms.all() == [])
        asked = asyncio.create_task(b.rooms.seek(room.id))
        await turns()
        assert not asked.done()
        arrived.set()
        with pytest.raises(LeaseLostError) as found:
            await asked
        assert found.value.holder == "a"
        await leaving
        assert (await a.rooms.seek(room.id)).id == room.id


async def test_simultaneous_requests_find_the_same_room(address: str) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.create(BOARD)
        await a.stored.leaving.migrate(room.id)
        found = await asyncio.gather(*[b.rooms.seek(room.id) for _ in range(8)])
        assert {id(each) for each in found} == {id(b.rooms.find(room.id))}
        lease = b.leases.book.of(room.id)
        assert lease is not None
        row = await b.ledger.read(lease_store.holder_of, room=room.id)
        assert row is not None
        assert row.number == lease.number


async def test_a_take_over_that_is_overtaken_is_no_damage(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.seek("main")
        await a.drop(room, 1)
        recovery = b.rooms.persistence.recovery
        reading, overtaken = recovery._read, asyncio.Event()

        async def overtake(read: Any, **values: Any) -> Any:
            if "run" in values and not overtaken.is_set():  # facts after the previous row
                overtaken.set()
                again = await a.stored.arriving.take("main")
                assert again is not None
                await a.run(again, 100)
                await a.drop(again, 2)
            return await reading(read, **values)

        monkeypatch.setattr(recovery, "_read", overtake)
        a.stored.leaving.put_away("main")
        with pytest.raises(LeaseLostError):
            await b.stored.arriving.take("main")
        assert overtaken.is_set()
        assert (recovery.set_aside, b.rooms.all(), b.leases.book.rooms) == ({}, [], [])
        assert [each.room.input_count for each in a.rooms.all()] == [2]


async def test_a_halt_at_one_server_is_one_at_all(address: str) -> None:
    async with two(address) as (a, b):
        room = await b.rooms.seek("main")
        await a.rooms.orders.give(HALT, EVERY_ROOM)
        await b.rooms.orders.follow()
        with pytest.raises(HaltedError):
            await ask(room, 3)
        await b.rooms.orders.give(RELEASE, EVERY_ROOM)
        await a.rooms.orders.follow()
        assert a.rooms.orders.since == {}
        await b.drop(room, 3)


async def test_players_rooms_are_counted_at_all_servers(address: str) -> None:
    async with two(address, max_rooms=3) as (a, b):
        made = [await life.rooms.create(BOARD) for life in (a, b, a)]
        for life in (a, b):
            with pytest.raises(RoomLimitError):
                await life.rooms.create(BOARD)
        await a.rooms.delete(made[0])
        await b.rooms.create(BOARD)
        with pytest.raises(UnknownRoomError):
            await b.rooms.seek(made[0].id)


async def test_an_address_s_rooms_are_counted_at_all_servers(address: str) -> None:
    async with two(address) as (a, b):
        for life, mark in ((a, "one"), (b, "one"), (a, "other")):
            room = await life.rooms.create(BOARD, creator=mark)
        assert [await b.stored.made_by(mark) for mark in ("one", "other", "none")] == [
            2,
            1,
            0,
        ]
        await a.rooms.reset(room)
        await a.stored.leaving.migrate(room.id)
        await b.rooms.reset(await b.rooms.seek(room.id))
        assert await a.stored.made_by("other") == 1
        await b.rooms.delete(b.rooms.find(room.id))
        assert await a.stored.made_by("other") == 0


async def test_an_unused_room_closes_anywhere_once_the_ledger_answers(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with two(address) as (a, b):
        room = await a.rooms.create(BOARD)
        await a.stored.leaving.migrate(room.id)
        used = (await b.row(room.id)).used
        b.rooms.persistence.runs.now = lambda: used + UNUSED_SECONDS + 1.0
        with monkeypatch.context() as broken:
            broken.setattr(lease_store, "take", no_answer)
            with pytest.raises(LedgerError):
                await b.stored.renew()
        await asked_again(b.stored.renew)
        await asked_again(b.heard)
        assert await b.ledger.read(lambda c: store.open_room(c, room.id)) is None
        with pytest.raises(UnknownRoomError):
            await b.rooms.seek(room.id)


def no_answer(*_: object, **__: object) -> None:
    """Raise the error of a statement to an unreachable database."""
    raise OSError("nobody answers")


async def asked_again(work: Callable[[], Awaitable[object]]) -> None:
    """Await this work, with retries if the ledger of a busy machine does not answer in time."""
    async with asyncio.timeout(LIMIT):
        while True:
            with contextlib.suppress(LedgerError):
                await work()
                return


def test_tables_are_made_even_on_a_busy_machine(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    database, make = Database(address, shared=True), tables.metadata.create_all
    patience = sa.text("SHOW idle_in_transaction_session_timeout")
    found: list[str] = []

    def made(connection: sa.Connection, **how: Any) -> None:
        found.append(connection.execute(patience).scalar_one())
        make(connection, **how)

    monkeypatch.setattr(tables.metadata, "create_all", made)
    database.open()
    with database.transaction() as connection:
        found.append(connection.execute(patience).scalar_one())
    database.close()
    assert found == ["1min", "2s"], "later, a server that freezes keeps no room from the others"


async def test_sessions_have_numbers_of_their_own_at_every_server(address: str) -> None:
    async with two(address) as (a, b):
        rooms = [await life.rooms.create(BOARD) for life in (a, b) * 5]
        numbers = await a.ledger.read(store.run_numbers)
        assert len(set(numbers)) == len(numbers) == len(rooms)


# Players' sessions.


class SameKey(SigningKey):
    """The key of both servers."""

    def __init__(self) -> None:
        self._signer = Signer(b"\x07" * 32)


def fair(life: Life) -> FairSessions:
    return FairSessions(
        life.rooms.persistence,
        SameKey(),
        kernel_digest=KERNEL,
        rest=1e6,
        draw=lambda count: b"\x01" * count,
        new_id=iter(f"{number}" for number in range(99)).__next__,
        having=life.stored.having,
    )


async def test_a_player_s_session_goes_on_where_its_room_does(address: str) -> None:
    async with two(address) as (a, b):
        at_a, at_b = fair(a), fair(b)
        room = await a.rooms.create(BOARD)
        session = await at_a.begin(room.room, hashlib.sha256(SECRET).hexdigest())
        await at_a.open(session, SECRET.hex())
        for _ in range(3):
            await a.drop(room, None, session=session, stake=10)
        moved = await b.stored.arriving.take(room.id)
        assert moved is not None
        stale = ask(room, None, session=session, stake=10)
        with pytest.raises(LeaseLostError):
            await stale
        there = await at_b.find(session.id)
        for _ in range(2):
            await b.drop(moved, None, session=there, stake=10)
        await b.rest()
        # The room returns: the first server forgot the session when the room left.
        await b.stored.leaving.migrate(room.id)
        again = await at_a.find(session.id)
        assert again.drops == 5
        await at_a.end(again)
        export = msgspec.json.decode(await at_a.export(again))
        verdict = check_session(
            read_export(export), kernel_digest=KERNEL, key=Signer(b"\x07" * 32).public.hex()
        )
        assert (verdict.failed, verdict.drops) == ([], 5)
