"""Servers see each other in a table of a real PostgreSQL, whose clock is the judge."""

import asyncio
import contextlib
import signal
from collections.abc import Iterator

import psycopg
import pytest

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import Member, Seen
from app.persistence.ledger.database import address
from tests.app.persistence import postgres
from tests.waiting import LIMIT

A, B = Member("a.1", "a", "http://a"), Member("b.1", "b", "http://b")

pytestmark = pytest.mark.postgresql


@pytest.fixture(scope="module")
def database(postgresql: postgres.Cluster) -> str:
    return postgresql.new_database()


@pytest.fixture
def both(database: str) -> Iterator[tuple[Beats, Beats]]:
    beats = Beats(address(database)), Beats(address(database))
    yield beats
    for each in beats:
        each.close()
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute("DELETE FROM members")


async def seen(beats: Beats, me: Member) -> dict[str, Seen]:
    return {each.member.name: each for each in (await beats.beat(me)).found}


async def test_each_sees_the_other_and_how_long_ago_it_said_so(
    both: tuple[Beats, Beats], database: str
) -> None:
    first, second = both
    await first.beat(A)
    found = await seen(second, B)
    assert {name: each.member for name, each in found.items()} == {"a": A, "b": B}
    assert all(each.connected and 0.0 <= each.age < LIMIT for each in found.values())
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute("UPDATE members SET beat = beat - interval '7 s' WHERE name = 'a'")
    assert (await seen(second, B))["a"].age >= 7.0


async def test_one_whose_process_has_ended_has_no_connection(
    both: tuple[Beats, Beats], database: str
) -> None:
    ending, second = Beats(address(database)), both[1]
    await ending.beat(A)
    ending.close()  # as the system does for a process that was killed: nobody says goodbye

    async def connected() -> bool:
        return (await seen(second, B))["a"].connected

    async with asyncio.timeout(LIMIT):
        while await connected():
            pass


async def test_who_waits_is_told_at_once_of_one_that_leaves(both: tuple[Beats, Beats]) -> None:
    first, second = both
    await first.beat(A)
    await second.beat(B)
    waiting = asyncio.create_task(second.until_told(LIMIT))
    await first.leave(A)
    await waiting
    assert (await seen(second, B)).keys() == {"b"}


async def test_a_server_whose_connection_was_ended_beats_over_another_at_once(
    both: tuple[Beats, Beats], database: str
) -> None:
    first, second = both
    assert (await first.beat(A)).connection == 1
    with psycopg.connect(database, autocommit=True) as connection:
        connection.execute("SELECT pg_terminate_backend(pid) FROM members WHERE name = 'a'")
    assert (await first.beat(A)).connection == 2, "and knows that the others may have lost theirs"
    found = (await seen(second, B))["a"]
    assert found.connected


async def test_a_postgresql_that_stands_still_or_is_away_is_nobody_s_loop_to_wait_for(
    postgresql: postgres.Cluster, database: str
) -> None:
    beats, frozen = Beats(address(postgresql.url("nowhere"))), Beats(address(database))
    with pytest.raises(FAILURES):
        await beats.beat(A)
    beats.close()
    assert postgresql.process is not None
    postgresql.process.send_signal(signal.SIGSTOP)  # it takes connections and says nothing
    try:
        with pytest.raises(TimeoutError):
            await frozen.beat(A)
    finally:
        postgresql.process.send_signal(signal.SIGCONT)
    async with asyncio.timeout(LIMIT):
        while "a" not in await answered(frozen):
            pass
    frozen.close()


async def answered(beats: Beats) -> set[str]:
    """Who is seen, if PostgreSQL answers."""
    with contextlib.suppress(*FAILURES):
        return set(await seen(beats, A))
    return set()
