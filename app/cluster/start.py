"""Puts this server's end of the cluster together; imported where one is asked for."""

import asyncio
import contextlib
import functools
import logging
import socket
from typing import Final

from starlette.applications import Starlette

from app.cluster.alive import Alive
from app.cluster.hand_on import HandOn
from app.cluster.membership import Member, order
from app.cluster.peers import Peers
from app.cluster.take_over import TakeOver
from app.errors import AppError, InvalidValueError, shorten
from app.listening import address_of
from app.live.shared_rooms import SharedRooms
from app.persistence.lease_book import LeaseBook
from app.persistence.ledger.database import address
from app.persistence.ledger.writer import Ledger
from app.settings import Settings
from app.web.shared import Standing

_AT_ONCE: Final = 4
"""Rooms that are handed over at a time: no more than a server brings back at a time. Each stands
still until the other server has it."""

_log = logging.getLogger("plinko")


def member(settings: Settings, book: LeaseBook) -> Alive:
    """This server among the others; raises SettingError."""
    database = address(settings.ledger_url).set(drivername="postgresql")
    return Alive(database.render_as_string(hide_password=False), book, settings.name)


class Cluster:
    """What `app.main` starts and stops, and what routes know of the other servers."""

    def __init__(
        self, settings: Settings, alive: Alive, rooms: SharedRooms, ledger: Ledger
    ) -> None:
        self.name = settings.name
        self._host = settings.host
        self._book = rooms.leases.book
        self._alive = alive
        self._rooms = rooms
        self._peers = Peers()
        self._take_over = TakeOver(alive, rooms, ledger)
        self._handed_over = 0  # rooms

    def surround(self, app: Starlette) -> None:
        """Have each request brought to the server that has its room."""
        fetch = self._rooms.arriving.fetch
        app.add_middleware(HandOn, alive=self._alive, peers=self._peers, fetch=fetch)

    def listens(self, listener: socket.socket) -> None:
        """It listens here: unless it was told another address, the others reach it there."""
        port = listener.getsockname()[1]
        here = address_of(listener).rstrip("/")
        everywhere = self._host in ("0.0.0.0", "::", "")
        found = f"http://{socket.gethostname()}:{port}" if everywhere else here
        self._book.address = self._book.address or found

    async def run(self) -> None:
        """Be one of the servers until cancelled."""
        async with self._peers.http, asyncio.TaskGroup() as tasks:
            tasks.create_task(self._alive.run())
            tasks.create_task(self._take_over.run())

    async def until_joined(self) -> None:
        """Return once the others know of this server, or it is clear that this takes long."""
        await self._alive.until_known()

    # What routes ask.

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self._book.holder in self._alive.view.members

    @property
    def first(self) -> bool:
        """Whether this server does what one of them does for all: the first by its holder."""
        return self._book.holder == min(self._alive.view.members, default=None)

    def standing(self) -> Standing:
        """How this server stands among the others."""
        view = self._alive.view
        names = sorted(each.name for each in view.members.values())
        counts = (self._take_over.count, self._handed_over, self._peers.handed_on)
        return Standing(self.name, view.up, names, len(self._book.rooms), *counts)

    async def ask_all(self, path: str, part: str) -> list[object]:
        """What each of the others lists as `part` of its answer to a GET of this path."""
        others = [each for each in self._alive.view.members.values() if each != self._alive.me]
        return list(await asyncio.gather(*(self._peers.ask(each, path, part) for each in others)))

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        view = self._alive.view
        target = view.named(to)
        if target is None:
            names = ", ".join(sorted(each.name for each in view.members.values()))
            raise InvalidValueError(f"to={shorten(to)} is no server: there are {names}", field="to")
        if target.holder != self._book.holder:
            await self._give(room_id, target)
        return target

    async def leave(self) -> None:
        """Give all rooms to the others, each from the very tick at which it is; then be gone."""
        self._alive.leaving = True
        await self._alive.until_known()
        turns, others = asyncio.Semaphore(_AT_ONCE), self._alive.view.others(self._book.holder)

        async def give(room_id: str) -> None:
            async with turns:
                with contextlib.suppress(AppError):
                    if others:
                        await self._give(room_id, order(room_id, others)[0])
                    else:
                        await self._rooms.leaving.hand_over(room_id)

        await asyncio.gather(*map(give, self._book.rooms))

    async def _give(self, room_id: str, target: Member) -> None:
        there = {"holder": target.holder, "address": target.address}
        taken = functools.partial(self._peers.have_taken, target, room_id)
        await self._rooms.leaving.hand_over(room_id, taken, **there)
        self._handed_over += 1
        _log.info("room handed over", extra={"room": room_id, "to": target.name})
