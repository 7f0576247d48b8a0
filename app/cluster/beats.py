"""A table of PostgreSQL in which each server says that it is alive, over a connection of its own.

Ages are taken by the database's clock, so that no two machines need agree on the time. A server
that leaves notifies the others, and one whose process has ended has no connection any more.
"""

import asyncio
import contextlib
import os
import socket
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any, Final, TypeVar

import psycopg
from sqlalchemy.engine import URL

from app.cluster.membership import Look, Member, Seen

T = TypeVar("T")

_SECONDS: Final = 1.0
"""s that PostgreSQL may take to answer: beyond that it counts as away."""

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

_SAY: Final = """
INSERT INTO members VALUES (%s, %s, %s, %s, pg_backend_pid(), clock_timestamp())
ON CONFLICT (holder) DO UPDATE SET address = excluded.address, leaving = excluded.leaving,
  pid = excluded.pid, beat = excluded.beat
"""

_LOOK: Final = f"""
SELECT holder, name, address, leaving,
  extract(epoch FROM clock_timestamp() - beat)::float8, activity.pid IS NOT NULL
FROM members LEFT JOIN pg_stat_activity AS activity USING (pid)
WHERE beat > clock_timestamp() - {_FORGOTTEN}
"""


class Beats:
    """For the event loop's thread."""

    def __init__(self, database: URL) -> None:
        plain = database.set(drivername="postgresql")
        self._address = plain.render_as_string(hide_password=False)
        self._connection: psycopg.AsyncConnection[tuple[Any, ...]] | None = None
        self._connections = 0  # until now
        self._working: asyncio.Task[Any] | None = None

    async def beat(self, me: Member) -> Look:
        """Say that `me` is alive, and see who else is; raises FAILURES."""
        return await self._within(_SECONDS, lambda: self._beat(me))

    async def until_told(self, seconds: float) -> None:
        """Wait, for less time where a server says that it leaves; raises FAILURES."""
        await self._within(seconds + _SECONDS, lambda: self._wait(seconds))

    async def leave(self, me: Member) -> None:
        """Say that `me` is gone; raises FAILURES."""
        await self._within(_SECONDS, lambda: self._forget(me))

    def close(self) -> None:
        """Leave PostgreSQL, whatever it is asked."""
        connection, self._connection = self._connection, None
        if connection is None:
            return
        if self._busy:  # it hears of the end, and closes the connection
            _cut(connection)
        else:
            connection.pgconn.finish()

    @property
    def _busy(self) -> bool:
        return self._working is not None and not self._working.done()

    async def _within(self, seconds: float, work: Callable[[], Coroutine[Any, Any, T]]) -> T:
        """What comes of `work`, once what was asked before is answered.

        What takes too long goes on all the same: a connection is not lost for being slow, and the
        driver could not cancel anything without PostgreSQL.
        """
        try:
            async with asyncio.timeout(seconds):
                while self._working is not None and self._busy:
                    await asyncio.wait([self._working])
                task = self._working = asyncio.create_task(work())
                task.add_done_callback(lambda done: done.cancelled() or done.exception())
                return await asyncio.shield(task)
        except TimeoutError:
            raise TimeoutError(f"PostgreSQL has not answered for {seconds:g} s") from None

    async def _beat(self, me: Member) -> Look:
        """Over a new connection where the one that there was has ended."""
        if self._connection is not None:
            with contextlib.suppress(psycopg.OperationalError):
                return await self._say(me)
        return await self._say(me)

    async def _say(self, me: Member) -> Look:
        async with self._connected() as connection:
            await connection.execute(_SAY, (me.holder, me.name, me.address, me.leaving))
            if me.leaving:
                await connection.execute("NOTIFY members")
            rows = await (await connection.execute(_LOOK)).fetchall()
        found = (Seen(Member(*row[:4]), age=row[4], connected=row[5]) for row in rows)
        return Look(self._connections, tuple(found))

    async def _wait(self, seconds: float) -> None:
        async with self._connected() as connection:
            async for _ in connection.notifies(timeout=seconds, stop_after=1):
                pass

    async def _forget(self, me: Member) -> None:
        async with self._connected() as connection:
            await connection.execute("DELETE FROM members WHERE holder = %s", (me.holder,))
            await connection.execute("NOTIFY members")

    @contextlib.asynccontextmanager
    async def _connected(self) -> AsyncIterator[psycopg.AsyncConnection[tuple[Any, ...]]]:
        """The connection, made again after a failure."""
        connection = self._connection or await self._connect()
        try:
            if self._connection is None:
                await connection.execute(_MAKE)
                self._connection = connection
                self._connections += 1
            yield connection
        except psycopg.Error:
            self._connection = None
            await connection.close()
            raise

    async def _connect(self) -> psycopg.AsyncConnection[tuple[Any, ...]]:
        return await psycopg.AsyncConnection.connect(
            self._address,
            autocommit=True,
            connect_timeout=_CONNECT,
            tcp_user_timeout=1000 * _CONNECT,
            application_name="plinko beats",
            # A server that is seen to be alive may be so a moment longer than it is.
            options="-c synchronous_commit=off",
        )


def _cut(connection: psycopg.AsyncConnection[Any]) -> None:
    """End a connection under whoever waits for what does not come."""
    with (
        contextlib.suppress(OSError, psycopg.Error),
        socket.socket(fileno=os.dup(connection.fileno())) as end,
    ):
        end.shutdown(socket.SHUT_RDWR)
