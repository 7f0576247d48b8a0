"""Puts this server's end of the cluster together; imported where one is asked for."""

import asyncio
import contextlib
import socket
from collections.abc import Callable
from typing import Any, Final

from starlette.applications import Starlette

from app.cluster.alive import Alive
from app.cluster.beats import Beats
from app.cluster.hand_on import HandOn
from app.cluster.hand_over import HandOver
from app.cluster.membership import Member
from app.cluster.peers import Peers
from app.cluster.take_over import TakeOver
from app.errors import SettingError
from app.listening import address_of
from app.live.shared_rooms import SharedRooms
from app.persistence.lease_book import LeaseBook
from app.persistence.ledger.database import address
from app.persistence.ledger.writer import Ledger
from app.settings import Settings
from app.web.shared import Standing

_JOIN: Final = 5.0
"""s that a start waits for the table of members; then the server goes on, and is not ready."""


def member(settings: Settings, book: LeaseBook) -> Alive:
    """This server among the others; raises SettingError."""
    if settings.address and not settings.address.startswith(("http://", "https://")):
        raise SettingError(
            f"address={settings.address!r} is not an address such as http://10.0.0.1:8000",
            field="address",
        )
    return Alive(Beats(address(settings.ledger_url)), book, settings.name)


class Cluster:
    """What `app.main` starts and stops, and what routes know of the other servers.

    `watched` says how many watch a room.
    """

    def __init__(
        self,
        settings: Settings,
        alive: Alive,
        rooms: SharedRooms,
        ledger: Ledger,
        watched: Callable[[str], int],
    ) -> None:
        self.name = settings.name
        self._host = settings.host
        self._book = rooms.leases.book
        self._alive = alive
        self._rooms = rooms
        self._peers = Peers()
        self._hand_over = HandOver(alive, rooms, self._peers, watched)
        self._take_over = TakeOver(alive, rooms, ledger)

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
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._alive.run())
            tasks.create_task(self._take_over.run())

    async def until_joined(self) -> None:
        """Return once the others know of this server, or it is clear that this takes long."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_JOIN):
                while not self.joined:
                    await self._alive.looked.wait()

    async def gone(self) -> None:
        """This server has ended."""
        await self._alive.gone()
        await self._peers.close()
        await self._take_over.close()

    # What routes ask.

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self._alive.joined

    @property
    def first(self) -> bool:
        """Whether this server does what one of them does for all: the first by its holder."""
        return self._book.holder == min(self._alive.view.members, default=None)

    def standing(self) -> Standing:
        """How this server stands among the others."""
        view = self._alive.view
        names = sorted(each.name for each in view.members.values())
        counts = (self._take_over.count, self._hand_over.count, self._peers.handed_on)
        return Standing(self.name, view.up, names, len(self._book.rooms), *counts)

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        return await self._hand_over.move(room_id, to)

    async def leave(self) -> None:
        """Give all rooms to the others."""
        await self._hand_over.leave()

    async def ask_all(self, path: str, part: str) -> list[Any]:
        """What each of the others lists as `part` of its answer to a GET of this path."""
        me, members = self._book.holder, self._alive.view.members.values()
        others = [each for each in members if each.holder != me]
        return list(await asyncio.gather(*(self._peers.ask(each, path, part) for each in others)))
