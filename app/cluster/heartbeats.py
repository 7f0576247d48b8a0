"""The PostgreSQL table of heartbeats, which each server writes over its own connection.

The database's clock measures ages, so machines need not agree on the time. A server that leaves
notifies the others. A server whose process has ended no longer has a connection, which the others
see. All calls block, so they run on their own thread.
"""

import contextlib
from collections.abc import Iterator
from typing import Any, Final

import psycopg

from plinko.app.cluster.membership import HEARTBEAT, LEASE, Member, Seen

_CONNECT: Final = 3  # s
_FORGOTTEN: Final = "interval '1 minute'"
_LOCK: Final = 0x706C696E6B70  # the advisory lock for creating the table

FAILURES: Final = (psycopg.Error, OSError, TimeoutError)
"""The errors that all calls here raise while PostgreSQL is unavailable."""

# Unlogged: the table is not worth a write-ahead log, and a crash of PostgreSQL may empty it.
_MAKE: Final = f"""
SELECT pg_advisory_xact_lock({_LOCK});
CREATE UNLOGGED TABLE IF NOT EXISTS members (
  holder text PRIMARY KEY, name text NOT NULL, address text NOT NULL, leaving boolean NOT NULL,
  pid integer NOT NULL, beat timestamptz NOT NULL
) WITH (fillfactor = 50);
DELETE FROM members WHERE beat < clock_timestamp() - {_FORGOTTEN};
LISTEN members
"""

_HEARTBEAT: Final = f"""
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
"""Writes a server's heartbeat, and selects all servers as they were just before it."""


class Heartbeats:
    """A connection to the table. After a call has raised one of FAILURES, it is unusable."""

    def __init__(self, connection: psycopg.Connection[tuple[Any, ...]]) -> None:
        self._connection = connection

    @classmethod
    @contextlib.contextmanager
    def connected(cls, database: str) -> Iterator["Heartbeats"]:
        """Connect for the block, and create the table if it is missing."""
        connecting = psycopg.connect(
            database,
            autocommit=True,
            connect_timeout=_CONNECT,
            tcp_user_timeout=1000 * _CONNECT,
            application_name="plinko heartbeats",
            # No wait for the disk: a heartbeat need not survive a crash of PostgreSQL.
            options=f"-c synchronous_commit=off -c statement_timeout={LEASE:g}s",
        )
        with contextlib.closing(connecting) as connection:
            connection.execute(_MAKE)
            yield cls(connection)

    def send(self, me: Member) -> list[Seen]:
        """Write a heartbeat of `me`; returns all servers, `me` as of its previous heartbeat."""
        said = self._connection.execute(_HEARTBEAT, (me.holder, me.name, me.address, me.leaving))
        found = [Seen(Member(*row[:4]), age=row[4], connected=row[5]) for row in said]
        # `found` has the previous state of `me`, so only its first heartbeat as leaving notifies.
        if me.leaving and me not in [each.member for each in found]:
            self._connection.execute("NOTIFY members")
        return found

    def pause(self) -> None:
        """Wait until the next heartbeat is due, or until a server notifies that it leaves."""
        for _ in self._connection.notifies(timeout=HEARTBEAT, stop_after=1):
            pass
