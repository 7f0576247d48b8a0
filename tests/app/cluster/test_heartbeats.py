"""Servers find each other in a table of a real PostgreSQL, and use its clock."""

import asyncio
import contextlib
import itertools
import threading
from collections.abc import AsyncIterator, Iterator
from typing import LiteralString

import psycopg
import pytest

from plinko.app.cluster.alive import FAILURES, Alive, Heartbeats
from plinko.app.cluster.membership import HEARTBEAT, LEASE, Member, Seen
from plinko.app.persistence.lease_book import LeaseBook
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import LIMIT, eventually, until

A, B = Member("a.1", "a", "http://a"), Member("b.1", "b", "http://b")

pytestmark = pytest.mark.postgresql


@pytest.fixture(scope="module")
def database(postgresql: PostgreSQL) -> str:
    return postgresql.new_database()


@contextlib.contextmanager
def both(database: str) -> Iterator[tuple[Heartbeats, Heartbeats]]:
    """Two servers' connections to an empty table of members."""
    with Heartbeats.connected(database) as first, Heartbeats.connected(database) as second:
        do(database, "DELETE FROM members")
        yield first, second


def do(database: str, statement: LiteralString) -> None:
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute(statement)


def seen(heartbeats: Heartbeats, me: Member) -> dict[str, Seen]:
    return {each.member.name: each for each in heartbeats.send(me)}


def test_servers_see_each_other_and_the_age_of_heartbeats(database: str) -> None:
    with both(database) as (first, second):
        assert seen(first, A) == {}, "itself as it was before"
        found = seen(second, B)
        assert {name: each.member for name, each in found.items()} == {"a": A}
        do(database, "UPDATE members SET beat = beat - interval '7 s' WHERE name = 'a'")
        found = seen(second, B)
        assert found["a"].age >= 7.0
        assert 0.0 <= found["b"].age < LIMIT
        assert all(each.connected for each in found.values())


def test_one_whose_process_has_ended_has_no_connection(database: str) -> None:
    with both(database) as (_, second):
        with Heartbeats.connected(database) as ending:
            ending.send(A)
        until(lambda: not seen(second, B)["a"].connected)


def test_waiting_servers_learn_at_once_that_one_leaves(
    database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with both(database) as (first, second):
        monkeypatch.setattr("plinko.app.cluster.alive.HEARTBEAT", LIMIT)
        waiting = threading.Thread(target=second.pause)
        waiting.start()
        leaving = Member(A.holder, A.name, A.address, leaving=True)
        first.send(leaving)
        waiting.join(LIMIT / 2)
        assert not waiting.is_alive()
        assert (seen(second, B))["a"].member == leaving


def test_a_server_that_leaves_says_so_once(database: str) -> None:
    leaving = Member(A.holder, A.name, A.address, leaving=True)
    with both(database) as (first, _):
        with psycopg.connect(database, autocommit=True) as listening:
            listening.execute("LISTEN members")
            for me in (A, leaving, leaving, leaving):
                first.send(me)
            do(database, "NOTIFY members, 'the last'")
            told = itertools.count()
            for each in listening.notifies(timeout=LIMIT):
                if each.payload:
                    break
                next(told)
        assert next(told) == 1, "each notice wakes all servers, and itself"


def test_an_ended_connection_and_a_missing_database_are_failures(
    postgresql: PostgreSQL, database: str
) -> None:
    with both(database) as (first, _):
        first.send(A)
        do(database, "SELECT pg_terminate_backend(pid) FROM members WHERE name = 'a'")
        with pytest.raises(FAILURES):
            first.send(A)
    with pytest.raises(FAILURES), Heartbeats.connected(postgresql.url("nowhere")):
        pass


def test_a_postgresql_that_does_not_answer_is_given_up(database: str) -> None:
    with both(database) as (first, _), psycopg.connect(database) as locking:
        locking.execute("LOCK TABLE members")
        with pytest.raises(FAILURES):
            first.send(A)


def age(database: str) -> float:
    """Seconds since the last heartbeat of server `a`."""
    asked = "SELECT extract(epoch FROM clock_timestamp() - beat)::float8 FROM members"
    with psycopg.connect(database) as connection:
        (found,) = connection.execute(f"{asked} WHERE name = 'a'").fetchone() or (0.0,)
    return float(found)


@contextlib.asynccontextmanager
async def alive(database: str) -> AsyncIterator[None]:
    """Run server `a`, which sends heartbeats, until the block ends."""
    me = Alive(database, LeaseBook("a.1"), "a")
    beating = asyncio.create_task(me.run())
    await eventually(lambda: me.view.up)
    yield
    beating.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await beating


async def test_a_server_is_alive_while_its_loop_has_much_to_do(database: str) -> None:
    async with alive(database):
        # `until` blocks the event loop: the heartbeats must come from another thread.
        for _ in range(2):
            until(lambda: age(database) > HEARTBEAT / 2)
            until(lambda: age(database) < HEARTBEAT / 2)


async def test_a_server_whose_loop_does_not_come_round_is_not_alive(
    database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plinko.app.cluster.alive._STALLED_SECONDS", 2 * HEARTBEAT)
    async with alive(database):
        until(lambda: age(database) > LEASE)
