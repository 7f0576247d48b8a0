"""A table of PostgreSQL in which each server says that it is alive, over a connection of its own.

Ages are taken by the database's clock, so that no two machines need agree on the time. A server
that leaves notifies the others, and one whose process has ended has no connection any more.
"""

import asyncio
import contextlib
import os
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
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
    """For the event loop's thread; its connection is another's, which may have to wait."""

    def __init__(self, database: URL) -> None:
        plain = database.set(drivername="postgresql")
        self._address = plain.render_as_string(hide_password=False)
        self._connection: psycopg.Connection[tuple[Any, ...]] | None = None
        self._connections = 0  # until now
        self._thread = ThreadPoolExecutor(1, "beats")
        self._working: asyncio.Future[Any] | None = None

    async def beat(self, me: Member) -> Look:
        """Say that `me` is alive, and see who else is; raises FAILURES."""
        return await self._do(lambda: self._beat(me), _SECONDS)

    async def until_told(self, seconds: float) -> None:
        """Wait, for less time where a server says that it leaves; raises FAILURES."""
        await self._do(lambda: self._wait(seconds), seconds + _SECONDS)

    async def leave(self, me: Member) -> None:
        """Say that `me` is gone; raises FAILURES."""
        await self._do(lambda: self._forget(me), _SECONDS)

    def close(self) -> None:
        """Leave PostgreSQL, whatever the thread waits for."""
        if self._working is not None and not self._working.done():
            self._cut()
        self._thread.submit(self._drop)
        self._thread.shutdown(wait=False)

    async def _do(self, work: Callable[[], T], seconds: float) -> T:
        """Have the thread do this, unless it still waits for what it was to do before."""
        async with asyncio.timeout(seconds):
            if self._working is not None:
                await asyncio.wait([self._working])
            working = asyncio.get_running_loop().run_in_executor(self._thread, work)
            working.add_done_callback(lambda each: each.cancelled() or each.exception())
            self._working = working
            return await asyncio.shield(working)

    # In the thread.

    def _beat(self, me: Member) -> Look:
        """Over a new connection where the one that there was has ended."""
        if self._connection is not None:
            with contextlib.suppress(psycopg.OperationalError):
                return self._said(me)
        return self._said(me)

    def _said(self, me: Member) -> Look:
        with self._connected() as connection:
            connection.execute(_SAY, (me.holder, me.name, me.address, me.leaving))
            if me.leaving:
                connection.execute("NOTIFY members")
            rows = connection.execute(_LOOK).fetchall()
        found = (Seen(Member(*row[:4]), age=row[4], connected=row[5]) for row in rows)
        return Look(self._connections, tuple(found))

    def _wait(self, seconds: float) -> None:
        with self._connected() as connection:
            for _ in connection.notifies(timeout=seconds, stop_after=1):
                return

    def _forget(self, me: Member) -> None:
        with self._connected() as connection:
            connection.execute("DELETE FROM members WHERE holder = %s", (me.holder,))
            connection.execute("NOTIFY members")

    @contextlib.contextmanager
    def _connected(self) -> Iterator[psycopg.Connection[tuple[Any, ...]]]:
        """The connection, made again after a failure."""
        if self._connection is None:
            made = psycopg.connect(
                self._address,
                autocommit=True,
                connect_timeout=_CONNECT,
                tcp_user_timeout=1000 * _CONNECT,
                application_name="plinko beats",
                # A server that is seen to be alive may be so a moment longer than it is.
                options="-c synchronous_commit=off",
            )
            try:
                made.execute(_MAKE)
            except BaseException:
                made.close()
                raise
            self._connection = made
            self._connections += 1
        try:
            yield self._connection
        except psycopg.Error:
            self._drop()
            raise

    def _drop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _cut(self) -> None:
        """End the line under the thread, which would wait for what does not come."""
        connection = self._connection
        with contextlib.suppress(OSError, psycopg.Error):
            if connection is not None:
                with socket.socket(fileno=os.dup(connection.fileno())) as line:
                    line.shutdown(socket.SHUT_RDWR)
