"""A table of PostgreSQL in which each server says that it is alive, over a connection of its own.

Ages are taken by the database's clock, so that no two machines need agree on the time. A server
that leaves notifies the others, and one whose process has ended has no connection any more.
"""

import asyncio
import contextlib
import os
import socket
from collections.abc import AsyncIterator
from typing import Any, Final

import psycopg

from app.cluster.membership import BEAT, LEASE, Member, Seen

_CONNECT: Final = 3  # s
_FORGOTTEN: Final = "interval '1 minute'"
_LOCK: Final = 0x706C696E6B70  # under which the table is made

FAILURES: Final = (psycopg.Error, OSError, TimeoutError)
"""What any of this raises while PostgreSQL is away."""

# Nothing in it is worth keeping, so it has no write-ahead log; a crash of PostgreSQL empties it.
_MAKE: Final = f"""
SELECT pg_advisory_xact_lock({_LOCK});
CREATE UNLOGGED TABLE IF NOT EXISTS members (
  holder text PRIMARY KEY, name text NOT NULL, address text NOT NULL, leaving boolean NOT NULL,
  pid integer NOT NULL, beat timestamptz NOT NULL
) WITH (fillfactor = 50);
DELETE FROM members WHERE beat < clock_timestamp() - {_FORGOTTEN};
LISTEN members
"""

_BEAT: Final = f"""
WITH said AS (
  INSERT INTO members VALUES (%s, %s, %s, %s, pg_backend_pid(), clock_timestamp())
  ON CONFLICT (holder) DO UPDATE SET address = excluded.address, leaving = excluded.leaving,
    pid = excluded.pid, beat = excluded.beat
)
SELECT holder, name, address, leaving,
  extract(epoch FROM clock_timestamp() - beat)::float8, activity.pid IS NOT NULL
FROM members LEFT JOIN pg_stat_activity AS activity USING (pid)
WHERE beat > clock_timestamp() - {_FORGOTTEN}
"""
"""Says that a server is alive, and finds all as they were just before."""


class Beats:
    """A connection to the table. All of it raises FAILURES, after which the connection is over."""

    def __init__(self, connection: psycopg.AsyncConnection[tuple[Any, ...]]) -> None:
        self._connection = connection

    @classmethod
    @contextlib.asynccontextmanager
    async def connected(cls, database: str) -> AsyncIterator["Beats"]:
        """A connection in the block to the table, which is made where there is none."""
        connection = await psycopg.AsyncConnection.connect(
            database,
            autocommit=True,
            connect_timeout=_CONNECT,
            tcp_user_timeout=1000 * _CONNECT,
            application_name="plinko beats",
            # A server that is seen to be alive may be so a moment longer than it is.
            options="-c synchronous_commit=off",
        )
        try:
            beats = cls(connection)
            await beats._ask(_MAKE)
            yield beats
        finally:
            await connection.close()

    async def beat(self, me: Member) -> list[Seen]:
        """Say that `me` is alive; returns who was found, `me` as it was at its last beat."""
        asked = await self._ask(_BEAT, me.holder, me.name, me.address, me.leaving)
        rows = await asked.fetchall()
        found = [Seen(Member(*row[:4]), age=row[4], connected=row[5]) for row in rows]
        if me.leaving and me not in [each.member for each in found]:  # only once: it hears it too
            await self._ask("NOTIFY members")
        return found

    async def until_told(self, seconds: float) -> None:
        """Wait, for less time where a server says that it leaves."""
        async for _ in self._connection.notifies(timeout=seconds, stop_after=1):
            pass

    async def _ask(self, statement: str, *values: object) -> psycopg.AsyncCursor[tuple[Any, ...]]:
        """What PostgreSQL answers; a connection over which it does not is cut after a lease.

        The lease is counted in waits of a beat each, because PostgreSQL is not to blame for a time
        in which this process did not run. The connection is cut as nothing can be cancelled over it
        without PostgreSQL.
        """
        asking = asyncio.create_task(self._connection.execute(statement, values or None))
        try:
            for _ in range(round(LEASE / BEAT)):
                if (await asyncio.wait([asking], timeout=BEAT))[0]:
                    return asking.result()
        finally:
            if not asking.done():
                _cut(self._connection)
                await asyncio.wait([asking])
        raise TimeoutError(f"PostgreSQL has not answered for {LEASE:g} s")


def _cut(connection: psycopg.AsyncConnection[Any]) -> None:
    """End a connection under whoever waits for what does not come."""
    with (
        contextlib.suppress(OSError, psycopg.Error),
        socket.socket(fileno=os.dup(connection.fileno())) as end,
    ):
        end.shutdown(socket.SHUT_RDWR)
