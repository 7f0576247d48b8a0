"""Heartbeats: reports this server as alive, and finds out which other servers are.

Heartbeats have their own thread and connection, so that a slow ledger or a busy event loop does
not cost this server its rooms: moving them to other servers would only add to the load.
"""

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from typing import Any, Final

import psycopg

from plinko.app.cluster.membership import HEARTBEAT, LEASE, Member, Seen, View
from plinko.app.concurrency.single_flight import Signal
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.rooms.records import LeaseRow

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


_JOIN_SECONDS: Final = 5.0
"""How long start and shutdown wait for PostgreSQL. A server that starts without it is not ready."""

_STALLED_SECONDS: Final = 10.0
"""An event loop that has not handled a heartbeat for this long counts as stalled: heartbeats stop,
so that other servers take its rooms. Longer than the pauses of a busy machine."""

_log = logging.getLogger("plinko")


class Alive:
    """For the event loop's thread. `name` is this server's name for people.

    `looked` is sent after each heartbeat, successful or not. `leaving` is true while this server
    hands its rooms over. `database` is PostgreSQL's address.
    """

    def __init__(self, database: str, book: LeaseBook, name: str) -> None:
        self.name = name
        self.view = View()
        self.leaving = False
        self.looked = Signal()
        self._database = database
        self._book = book
        self._handled = 0.0  # when the event loop last handled a heartbeat, s of a monotonic clock
        self._depending: dict[asyncio.Timeout, str] = {}  # each with the holder it depends on

    @property
    def me(self) -> Member:
        """This server as the others see it."""
        return Member(self._book.holder, self.name, self._book.address, self.leaving)

    def claim(self, room_id: str, row: LeaseRow | None) -> int:
        """The number of the lease that this server's lease replaces; raises LeaseLostError."""
        return self.view.claim(room_id, row, self.me)

    async def run(self) -> None:
        """Send heartbeats until cancelled, also through failures of PostgreSQL."""
        self._handled = time.monotonic()
        loop, stop = asyncio.get_running_loop(), threading.Event()

        def call(handle: Callable[..., object], *args: object) -> None:
            if not stop.is_set():  # or else the loop may be closed, if PostgreSQL took long
                loop.call_soon_threadsafe(handle, *args)

        thread = threading.Thread(
            target=self._beat, args=(call, stop), name="heartbeats", daemon=True
        )
        thread.start()
        try:
            await asyncio.Event().wait()
        finally:
            stop.set()
            await asyncio.to_thread(thread.join, LEASE)

    def _beat(self, call: Callable[..., object], stop: threading.Event) -> None:
        while not stop.is_set():
            began = time.monotonic()
            try:
                with Heartbeats.connected(self._database) as heartbeats:
                    while not stop.is_set():
                        if time.monotonic() < self._handled + _STALLED_SECONDS:
                            me = self.me
                            call(self.look, me, heartbeats.send(me))
                        heartbeats.pause()
            except FAILURES as error:
                call(self.failed, error)
            # Reconnect at once if the connection lasted a while: others consider a server without
            # a connection failed after LATE instead of LEASE.
            stop.wait(began + HEARTBEAT - time.monotonic())

    def look(self, me: Member, found: Iterable[Seen]) -> None:
        """Update the view with the servers that the heartbeat of `me` found."""
        self._handled = time.monotonic()
        if late := self.view.look(me, found):
            _log.warning(
                "this server was late: its last heartbeat was %.1f s ago, and after %g s others "
                "may take its rooms",
                late,
                LEASE,
            )
        for limit, holder in list(self._depending.items()):
            if self.view.is_gone(holder):
                del self._depending[limit]
                limit.reschedule(0.0)
        self.looked.send()

    def failed(self, error: Exception) -> None:
        """Note that a heartbeat failed. The members known until now stay."""
        self._handled = time.monotonic()
        if self.view.up:
            _log.warning("heartbeats fail, so it is unknown which servers are alive: %s", error)
        self.view.failed()
        self.looked.send()

    @contextlib.asynccontextmanager
    async def while_there(self, member: Member) -> AsyncIterator[None]:
        """Raise TimeoutError in the block when `member` has failed."""
        async with asyncio.timeout(None) as limit:
            self._depending[limit] = member.holder
            try:
                yield
            finally:
                self._depending.pop(limit, None)

    async def until_known(self) -> None:
        """Return when the others know this server's current state, or after five seconds."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_JOIN_SECONDS):
                while self.me != self.view.members.get(self.me.holder):
                    await self.looked.wait()
