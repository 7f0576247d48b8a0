"""One server at a time leases a room; the ledger refuses another server's writes."""

import asyncio
import functools
import threading
from dataclasses import replace
from typing import Any

import pytest
import sqlalchemy as sa

from plinko.app.errors import LeaseLostError, SettingError
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.leases import Leases
from plinko.app.persistence.ledger.common_secrets import TOKENS, common_secret
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import fair_store, lease_store, store, tables, writing
from plinko.app.rooms.records import (
    BoardRow,
    Close,
    DropRow,
    FairEnd,
    FairOpening,
    FairSessionRow,
    Lease,
    LogLeaf,
    Mark,
    NewDrop,
    NewInput,
    ResultRow,
    RoomRow,
    SessionTurn,
    Void,
    Write,
)
from tests.app.persistence.ledger.stepped import Steps, Table, failure
from tests.kit.facts import new
from tests.kit.postgres import PostgreSQL
from tests.kit.told import Told
from tests.kit.waiting import LIMIT

BOARD = BoardRow("b" * 64, "board", "{}")
ROOM = RoomRow(1, "r", BOARD.digest, "independent", True, 60, 1, 1.0, 1.0)
DROP = DropRow(1, 0, 5, 7, stake=100)
RESULT = ResultRow(1, 0, 90, 2, 1.5, 1.4, 0.1, "d" * 64, None, 150)
SESSION = FairSessionRow("s", "r", BOARD.digest, "00", "{}", "00", 1.0, client_seed="11")

BEFORE: list[Write] = [BOARD, ROOM, new(DROP), SESSION]


@pytest.fixture
def address(postgresql: PostgreSQL) -> str:
    return postgresql.new_database()


class Server:
    """One of several servers that share a ledger, without rooms."""

    def __init__(self, url: str, name: str) -> None:
        self.database = Steps(url, shared=True)
        self.book = LeaseBook(name)
        self.ledger = Ledger(self.database, period=0.0, patience=60.0, leases=self.book)
        self.leases = Leases(self.ledger, now=lambda: 5.0)
        self.lost: list[str] = []

    async def __aenter__(self) -> "Server":
        await asyncio.to_thread(self.ledger.open)
        self.ledger.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.ledger.close()

    async def takes(self, room: str, session: int = 1) -> Lease:
        lease = await self.take(room)
        self.book.note(session, room)
        return lease

    async def take(self, room: str, after: int | None = None) -> Lease:
        lease = await self.leases.take(room, after, self.lost.append)
        assert lease is not None
        return lease

    async def all_rows(self) -> dict[str, list[Any]]:
        """All rows of the ledger, except leases and the writers' counters."""
        return await self.ledger.read(everything)


def everything(connection: sa.Connection) -> dict[str, list[Any]]:
    kept = [t for t in tables.metadata.sorted_tables if t not in (tables.leases, tables.writers)]
    return {
        table.name: sorted(map(tuple, connection.execute(sa.select(table))), key=repr)
        for table in kept
    }


WRITES: dict[str, Write] = {
    "a session": replace(ROOM, number=2, closed=9.0),
    "a drop": new(DROP),
    "an input": NewInput(1, 5, "{}"),
    "a result": RESULT,
    "a mark": Mark(1, 99, True, 9.0),
    "a checkpoint": Mark(1, 99, True, 9.0, b"world", 1),
    "stakes back": Void(1, 100, "why"),
    "a player's session": replace(SESSION, id="t"),
    "an opening": FairOpening("s", "r", "22"),
    "a session's end": FairEnd("s", "r", lambda drops: ("{}", "00")),
    "an end": Close(1, 101, 9.0),
}


@pytest.mark.parametrize("kept", [False, True], ids=["refused", "deferred"])
async def test_nothing_of_a_room_is_written_that_is_another_server_s(
    address: str, kept: bool
) -> None:
    async with Server(address, "older") as older, Server(address, "newer") as newer:
        await older.takes("r")
        await older.ledger.commit(*BEFORE)
        for name, write in WRITES.items():
            await older.takes("r")
            older.book.note(2, "r")
            await newer.takes("r")
            before = await newer.all_rows()
            heard: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
            if kept:
                older.ledger.defer([write], heard.set_result)
            else:
                asked = older.ledger.submit(write)
                heard.set_result((await asyncio.gather(asked, return_exceptions=True))[0])
            assert isinstance(await heard, LeaseLostError), name
            assert await newer.all_rows() == before, name
            assert (older.lost.pop(), older.book.rooms, older.ledger.problem) == ("r", [], None)
            # The server that leases the room can write the same row.
            newer.book.note(2, "r")
            await newer.ledger.commit(write)
            assert await newer.all_rows() != before, name


async def test_writes_of_other_rooms_still_succeed(address: str) -> None:
    async with Server(address, "older") as older, Server(address, "newer") as newer:
        await older.takes("r")
        await older.takes("other", 3)
        await older.ledger.commit(*BEFORE, replace(ROOM, number=3, id="other"))
        await newer.takes("r")
        told: list[tuple[str, object]] = []

        def note(name: str, asked: "asyncio.Future[None]") -> None:
            told.append((name, asked.exception()))

        drops = [DropRow(3, 0, 5, 7), DropRow(1, 1, 5, 7), DropRow(3, 1, 5, 7)]
        for drop in drops:
            name = f"{drop.room}-{drop.ball}"
            asked = older.ledger.submit(new(drop))
            asked.add_done_callback(functools.partial(note, name))
        marks = [Mark(1, 50, True, 9.0), Mark(3, 50, True, 9.0)]
        older.ledger.defer(marks)
        await older.ledger.read(lambda connection: None)
        assert {name for name, error in told if error is None} == {"3-0", "3-1"}
        assert [name for name, error in told if isinstance(error, LeaseLostError)] == ["1-1"]
        read = [functools.partial(store.run, number=number) for number in (1, 3)]
        assert [(await older.ledger.read(each)).tick for each in read] == [0, 50]


async def test_the_number_of_a_lease_only_grows(address: str) -> None:
    async with Server(address, "a") as a, Server(address, "b") as b:
        numbers = []
        for server in (a, b, b, a):
            numbers.append((await server.take("r")).number)
        lease = a.book.drop("r")
        assert lease is not None
        await a.leases.release(lease)
        row = await b.ledger.read(lease_store.holder_of, room="r")
        assert row is not None
        assert (row.holder, await b.ledger.read(lease_store.listing)) == ("", [])
        numbers += [row.number, (await b.take("r")).number]
        assert numbers == sorted(set(numbers))
        assert [
            (row.room, row.holder, row.taken) for row in await a.ledger.read(lease_store.listing)
        ] == [("r", "b", 5.0)]


async def test_of_two_that_take_a_room_after_the_same_lease_one_has_it(address: str) -> None:
    async with Server(address, "a") as a, Server(address, "b") as b:
        for after in (0, 1):
            both = [server.take("r", after) for server in (a, b)]
            came = await asyncio.gather(*both, return_exceptions=True)
            assert sorted(type(each).__name__ for each in came) == ["Lease", "LeaseLostError"]


async def test_a_released_room_is_not_written_by_its_former_server(address: str) -> None:
    async with Server(address, "a") as a:
        await a.takes("r")
        await a.ledger.commit(*BEFORE)
        lease = a.book.drop("r")
        assert lease is not None
        await a.leases.release(lease)
        before = await a.all_rows()
        a.book.add(lease, a.lost.append)  # as if the write had been submitted before the release
        a.book.note(1, "r")
        with pytest.raises(LeaseLostError):
            await a.ledger.commit(new(DROP))
        assert await a.all_rows() == before


# At every step of a commit.


class _Taken:
    """Lets another server take the room at one step of this server's ledger."""

    def __init__(self, url: str, step: int) -> None:
        self.other = Database(url, shared=True)
        self.other.open()
        self.left = step
        self.met = ""
        self.took: Lease | None = None

    def at(self, step: str) -> None:
        self.left -= 1
        if self.left == 0:
            self.met = step
            self.took = self.take()

    def take(self) -> Lease | None:
        with self.other.transaction() as connection:
            number = lease_store.take(connection, "main", "newer", "", 5.0, None)
        return None if number is None else Lease("main", number)

    def drops(self) -> list[int]:
        with self.other.transaction() as connection:
            row = store.open_room(connection, "main")
            return (
                [] if row is None else [d.seed for d, _ in store.drops(connection, row.number, 0)]
            )


def test_a_room_taken_during_a_commit_keeps_accepted_drops(address: str) -> None:
    met, step = [], 0
    while True:
        step += 1
        table = Table(address, {"main": Told("main")}, holder=f"older-{step}")
        other = _Taken(address, step)
        table.until(table.rooms.resume())
        table.until(table.rooms.seek("main"))
        before = other.drops()
        asked = [table.asks("main", 100 * step + seed) for seed in (1, 2)]
        table.database.at = other.at
        table.work()
        table.tick(1)
        table.work()
        table.database.at = lambda step: None
        told = [future.result() for future in asked if future and _came(future)]
        now = other.take()  # at that step it may have had to wait for this server's transaction
        assert now is not None
        kept = other.drops()
        assert [int(each.accepted.seed) for each in told] == kept[len(before) :], other.met
        if table.rooms.all():  # the server has not noticed yet
            late = table.asks("main", 100 * step + 3)
            assert late is not None
            table.work()
            assert isinstance(late.exception(), LeaseLostError)
            assert other.drops() == kept
        assert table.rooms.all() == []
        table.end()
        other.other.close()
        if not other.met:
            break
        met.append((other.met, len(kept) - len(before), other.took is not None))
    steps = [name for name, _, _ in met]
    assert {"connect", "SELECT", "INSERT INTO drops", "commit", "committed"} <= _short(steps)
    # Until the transaction reads the lease, the other can take the room; then it must wait.
    assert {kept for _, kept, took in met if took} == {0, 2}
    assert {kept for _, kept, took in met if not took} == {2}


def _came(asked: "asyncio.Future[Any]") -> bool:
    return asked.done() and asked.exception() is None


def _short(steps: list[str]) -> set[str]:
    words = [step.split() for step in steps]
    return {" ".join(each[:3]) if each[0] == "INSERT" else each[0] for each in words}


# Exclusive and shared use of the database.


def test_sharing_and_unsharing_servers_exclude_each_other(
    address: str,
) -> None:
    one, two, alone = (
        Database(address, shared=True),
        Database(address, shared=True),
        Database(address),
    )
    one.open()
    two.open()
    with pytest.raises(SettingError, match="another server uses it"):
        alone.open()
    one.close()
    two.close()
    alone.open()
    with pytest.raises(SettingError, match="another server uses it exclusively"):
        Database(address, shared=True).open()
    alone.close()


def test_a_ledger_in_a_file_is_not_shared(tmp_path: Any) -> None:
    with pytest.raises(SettingError, match="on PostgreSQL"):
        Database(f"sqlite:///{tmp_path / 'plinko.db'}", shared=True)


def test_servers_that_start_at_once_make_the_tables_once(address: str) -> None:
    databases = [Database(address, shared=True) for _ in range(4)]
    failed: list[BaseException] = []

    def start(database: Database) -> None:
        try:
            database.open()
        except BaseException as error:  # noqa: BLE001
            failed.append(error)

    threads = [threading.Thread(target=start, args=[each]) for each in databases]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failed == []
    secrets = {common_secret(database, TOKENS) for database in databases}
    assert len(secrets) == 1
    for database in databases:
        database.close()


async def test_receipts_of_several_servers_make_one_log(address: str) -> None:
    async with Server(address, "a") as a, Server(address, "b") as b:
        servers = {1: a, 2: b}
        await begin(a, 1)
        await begin(b, 2)

        async def play(number: int) -> list[NewDrop]:
            return [await servers[number].ledger.drop(drop_of(number)) for _ in range(30)]

        asked = [each for found in await asyncio.gather(play(1), play(2)) for each in found]
        by_place = {each.receipt.index: each for each in asked if each.receipt}
        assert sorted(by_place) == list(range(60))
        alone = Database("sqlite://")
        alone.open()
        with alone.transaction() as connection:
            again = [
                LogLeaf("s1", place, 1, place, {"time": 1}, entry, lambda place, root, log: "00")
                for place, entry in enumerate(
                    f"{by_place[place].room}-{by_place[place].fact.ball}".encode()  # type: ignore[union-attr]
                    for place in range(60)
                )
            ]
            writing.apply(connection, [BOARD, ROOM, replace(SESSION, id="s1")])
            fair_store.add_leaves(connection, again)
        assert [leaf.root for leaf in again] == [
            by_place[place].receipt.root  # type: ignore[union-attr]
            for place in range(60)
        ]
        alone.close()


async def begin(server: Server, number: int) -> None:
    """Write a room with a player's session."""
    await server.takes(f"r{number}", number)
    room = replace(ROOM, number=number, id=f"r{number}")
    session = replace(SESSION, id=f"s{number}", room=f"r{number}")
    await server.ledger.commit(BOARD, room, session)


def drop_of(number: int) -> NewDrop:
    """The next drop of a session in a room."""

    def leaf(n: int, fact: DropRow) -> LogLeaf:
        entry = f"{number}-{n}".encode()
        place = (f"s{number}", n, number, fact.ball)
        return LogLeaf(*place, {"time": 1}, entry, lambda place, root, log: "00")

    turn = SessionTurn(f"s{number}", 1000, lambda n: 7, leaf)
    return replace(new(DropRow(number, 0, 5, 7)), session=turn)


def answers_nothing(server: Server) -> threading.Event:
    """Cut the connection after the next commit; later ones wait until the event is set."""
    go_on = threading.Event()
    cuts: list[str] = []

    def at(step: str) -> None:
        if step == "committed" and not cuts:
            cuts.append(step)
            raise failure()
        if step == "connect" and cuts:
            assert go_on.wait(LIMIT)

    server.database.at = at
    return go_on


async def test_an_unanswered_commit_is_reported_when_it_is_found(
    address: str,
) -> None:
    async with Server(address, "a") as a, Server(address, "b") as b:
        await begin(a, 1)
        await begin(b, 2)
        go_on = answers_nothing(a)
        waiting = asyncio.create_task(a.ledger.drop(drop_of(1)))
        while not (await b.all_rows())["receipts"]:
            await asyncio.sleep(0)
        assert not waiting.done()
        await b.ledger.drop(drop_of(2))
        before = await b.all_rows()
        go_on.set()
        receipt = (await waiting).receipt
        assert receipt is not None
        assert (receipt.index, a.lost) == (0, [])
        await a.ledger.drop(drop_of(1))
        after = await b.all_rows()
        assert after["receipts"][:2] == before["receipts"], "what the log has stays as it is"
        assert [row[3:5] for row in after["receipts"]] == [(1, 0), (2, 0), (1, 1)]
