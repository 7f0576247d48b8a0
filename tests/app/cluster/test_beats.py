"""Servers see each other in a table of a real PostgreSQL, whose clock is the judge."""

import asyncio
import contextlib
import itertools
import time
from collections.abc import AsyncIterator, Iterator
from typing import LiteralString

import psycopg
import pytest

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import Member, Seen
from tests.app.persistence import postgres
from tests.waiting import LIMIT, eventually, turns

A, B = Member("a.1", "a", "http://a"), Member("b.1", "b", "http://b")

pytestmark = pytest.mark.postgresql


@pytest.fixture(scope="module")
def database(postgresql: postgres.Cluster) -> str:
    return postgresql.new_database()


@contextlib.asynccontextmanager
async def both(database: str) -> AsyncIterator[tuple[Beats, Beats]]:
    """Connections of two servers, over a table without members."""
    async with Beats.connected(database) as first, Beats.connected(database) as second:
        do(database, "DELETE FROM members")
        yield first, second


def do(database: str, statement: LiteralString) -> None:
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute(statement)


async def seen(beats: Beats, me: Member) -> dict[str, Seen]:
    return {each.member.name: each for each in await beats.beat(me)}


async def test_each_sees_the_other_and_how_long_ago_it_said_so(database: str) -> None:
    async with both(database) as (first, second):
        assert await seen(first, A) == {}, "itself as it was before"
        found = await seen(second, B)
        assert {name: each.member for name, each in found.items()} == {"a": A}
        do(database, "UPDATE members SET beat = beat - interval '7 s' WHERE name = 'a'")
        found = await seen(second, B)
        assert found["a"].age >= 7.0
        assert 0.0 <= found["b"].age < LIMIT
        assert all(each.connected for each in found.values())


async def test_one_whose_process_has_ended_has_no_connection(database: str) -> None:
    async with both(database) as (_, second):
        async with Beats.connected(database) as ending:
            await ending.beat(A)

        async def connected() -> bool:
            return (await seen(second, B))["a"].connected

        async with asyncio.timeout(LIMIT):
            while await connected():
                pass


async def test_who_waits_is_told_at_once_of_one_that_leaves(database: str) -> None:
    async with both(database) as (first, second):
        waiting = asyncio.create_task(second.until_told(LIMIT))
        leaving = Member(A.holder, A.name, A.address, leaving=True)
        await first.beat(leaving)
        await waiting
        assert (await seen(second, B))["a"].member == leaving


async def test_a_server_that_leaves_says_so_once(database: str) -> None:
    leaving = Member(A.holder, A.name, A.address, leaving=True)
    async with both(database) as (first, _):
        with psycopg.connect(database, autocommit=True) as listening:
            listening.execute("LISTEN members")
            for me in (A, leaving, leaving, leaving):
                await first.beat(me)
            do(database, "NOTIFY members, 'the last'")
            told = itertools.count()
            for each in listening.notifies(timeout=LIMIT):
                if each.payload:
                    break
                next(told)
        assert next(told) == 1, "each notice wakes all servers, and itself"


async def test_a_connection_that_was_ended_is_a_failure_and_so_is_a_database_that_is_not_there(
    postgresql: postgres.Cluster, database: str
) -> None:
    async with both(database) as (first, _):
        await first.beat(A)
        do(database, "SELECT pg_terminate_backend(pid) FROM members WHERE name = 'a'")
        with pytest.raises(FAILURES):
            await first.beat(A)
    with pytest.raises(FAILURES):
        async with Beats.connected(postgresql.url("nowhere")):
            pass


@contextlib.contextmanager
def unanswered(database: str) -> Iterator[None]:
    """PostgreSQL answers nobody who beats, in the block."""
    with psycopg.connect(database) as connection:
        connection.execute("LOCK TABLE members")
        yield


def waits(database: str) -> bool:
    """Whether PostgreSQL has been asked and does not answer."""
    with psycopg.connect(database) as connection:
        waiting = connection.execute("SELECT FROM pg_locks WHERE NOT granted")
        return waiting.fetchone() is not None


async def test_a_postgresql_that_does_not_answer_is_given_up(database: str) -> None:
    async with both(database) as (first, _):
        with unanswered(database), pytest.raises(TimeoutError, match="not answered for 2 s"):
            await first.beat(A)
        with pytest.raises(FAILURES):
            await first.beat(A)


async def test_whoever_stops_meanwhile_does_not_wait_for_postgresql(database: str) -> None:
    async with both(database) as (first, _):
        with unanswered(database):
            beating = asyncio.create_task(first.beat(A))
            await eventually(lambda: waits(database))
            beating.cancel()
            with pytest.raises(asyncio.CancelledError):
                await beating


async def test_a_server_that_is_late_itself_does_not_give_postgresql_up(
    database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The loop's clock is the test's: it jumps, as if the process had stood still."""
    monkeypatch.setattr("app.cluster.beats.LEASE", LIMIT)
    loop, jump = asyncio.get_running_loop(), 0.0
    monkeypatch.setattr(loop, "time", lambda: time.monotonic() + jump)
    async with both(database) as (first, second):
        with unanswered(database):
            beating = asyncio.create_task(first.beat(A))
            await eventually(lambda: waits(database))
            jump = 10 * LIMIT
            await turns()
        await beating
        assert (await seen(second, B)).keys() == {"a"}
