"""A table of PostgreSQL in which each server says that it is alive, over a connection of its own.

Ages are taken by the database's clock, so that no two machines need agree on the time. A server
that leaves notifies the others, and one whose process has ended has no connection any more. All of
it blocks: it is for a thread of its own.
"""

import contextlib
from collections.abc import Iterator
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

    def __init__(self, connection: psycopg.Connection[tuple[Any, ...]]) -> None:
        self._connection = connection

    @classmethod
    @contextlib.contextmanager
    def connected(cls, database: str) -> Iterator["Beats"]:
        """A connection in the block to the table, which is made where there is none."""
        connecting = psycopg.connect(
            database,
            autocommit=True,
            connect_timeout=_CONNECT,
            tcp_user_timeout=1000 * _CONNECT,
            application_name="plinko beats",
            # A server that is seen to be alive may be so a moment longer than it is.
            options=f"-c synchronous_commit=off -c statement_timeout={LEASE:g}s",
        )
        with contextlib.closing(connecting) as connection:
            connection.execute(_MAKE)
            yield cls(connection)

    def beat(self, me: Member) -> list[Seen]:
        """Say that `me` is alive; returns who was found, `me` as it was at its last beat."""
        said = self._connection.execute(_BEAT, (me.holder, me.name, me.address, me.leaving))
        found = [Seen(Member(*row[:4]), age=row[4], connected=row[5]) for row in said]
        if me.leaving and me not in [each.member for each in found]:  # only once: it hears it too
            self._connection.execute("NOTIFY members")
        return found

    def until_told(self) -> None:
        """Wait for the next beat, for less time where a server says that it leaves."""
        for _ in self._connection.notifies(timeout=BEAT, stop_after=1):
            pass
