"""This server's part of the cluster: joining, leaving, and handing rooms over.

Imported only if the settings ask for a cluster.
"""

import asyncio
import contextlib
import functools
import logging
import socket
from typing import Final

from starlette.types import ASGIApp

from plinko.app.cluster.alive import Alive
from plinko.app.cluster.fail_over import FailOver
from plinko.app.cluster.forward import Forward, Peers
from plinko.app.cluster.membership import Member, order
from plinko.app.errors import AppError, InvalidValueError
from plinko.app.listening import address_of
from plinko.app.live.stored_rooms import StoredRooms
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.persistence.ledger.database import address
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.settings import Settings
from plinko.app.web.shared import Standing
from plinko.engine.errors import shorten

_AT_ONCE: Final = 4
"""Rooms that are handed over at the same time: as many as a server restores at the same time. Each
room stands still until the other server has it."""

_log = logging.getLogger("plinko")


def member(settings: Settings, book: LeaseBook) -> Alive:
    """This server's heartbeat, not yet running; raises SettingError."""
    database = address(settings.ledger_url).set(drivername="postgresql")
    return Alive(database.render_as_string(hide_password=False), book, settings.name)


class Cluster:
    """The cluster as `plinko.app.main` starts and stops it, and as routes see it."""

    def __init__(
        self,
        settings: Settings,
        alive: Alive,
        rooms: StoredRooms,
        ledger: Ledger,
    ) -> None:
        self.name = settings.name
        self._host = settings.host
        self._book = ledger.leases
        self.alive = alive
        self._rooms = rooms
        self._peers = Peers()
        self._fail_over = FailOver(alive, rooms, ledger)
        self._migrated = 0  # rooms

    def surround(self, app: ASGIApp) -> ASGIApp:
        """`app` within the layer that forwards requests to the server that has their room."""
        return Forward(app, self.alive, self._peers, self._rooms.arriving.fetch)

    def listens(self, listener: socket.socket) -> None:
        """Publish this socket's address to the other servers, unless the settings give one."""
        port = listener.getsockname()[1]
        here = address_of(listener).rstrip("/")
        everywhere = self._host in ("0.0.0.0", "::", "")
        found = f"http://{socket.gethostname()}:{port}" if everywhere else here
        self._book.address = self._book.address or found

    async def run(self) -> None:
        """Send heartbeats and take over rooms until cancelled."""
        async with self._peers.http, asyncio.TaskGroup() as tasks:
            tasks.create_task(self.alive.run())
            tasks.create_task(self._fail_over.run())

    # For the routes.

    @property
    def joined(self) -> bool:
        """Whether the others know of this server."""
        return self._book.holder in self.alive.view.members

    @property
    def first(self) -> bool:
        """Whether this server does the work that only one server does: the first by holder."""
        return self._book.holder == min(self.alive.view.members, default=None)

    def standing(self) -> Standing:
        """The members as this server knows them, and its counts of rooms and requests."""
        view = self.alive.view
        names = sorted(each.name for each in view.members.values())
        counts = (self._fail_over.count, self._migrated, self._peers.forwarded)
        return Standing(self.name, view.up, names, len(self._book.rooms), *counts)

    async def ask_all(self, path: str, part: str) -> list[object]:
        """The list `part` in each other server's answer to a GET of `path`."""
        others = [each for each in self.alive.view.members.values() if each != self.alive.me]
        return list(await asyncio.gather(*(self._peers.ask(each, path, part) for each in others)))

    async def move(self, room_id: str, to: str) -> str:
        """Hand a room of this server over to the server named `to`; raises InvalidValueError."""
        view = self.alive.view
        target = view.named(to)
        if target is None:
            names = ", ".join(sorted(each.name for each in view.takers))
            text = f"to={shorten(to)} is not the name of a server; choose one of {names}"
            raise InvalidValueError(text, field="to")
        if target.holder != self._book.holder:
            await self._give(room_id, target)
        return target.name

    async def leave(self) -> None:
        """Hand all rooms over to the others. Each room continues from its current tick."""
        self.alive.leaving = True
        await self.alive.until_known()
        turns, others = asyncio.Semaphore(_AT_ONCE), self.alive.view.others(self._book.holder)

        async def give(room_id: str) -> None:
            async with turns:
                with contextlib.suppress(AppError):
                    if others:
                        await self._give(room_id, order(room_id, others)[0])
                    else:
                        await self._rooms.leaving.migrate(room_id)

        await asyncio.gather(*map(give, self._book.rooms))

    async def _give(self, room_id: str, target: Member) -> None:
        there = {"holder": target.holder, "address": target.address}
        taken = functools.partial(self._peers.have_taken, target, room_id)
        await self._rooms.leaving.migrate(room_id, taken, **there)
        self._migrated += 1
        _log.info("room handed over", extra={"room": room_id, "to": target.name})
