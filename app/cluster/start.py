"""Puts this server's end of the cluster together; imported where one is asked for."""

import asyncio
import functools
import socket
from typing import Any, Final

from starlette.types import ASGIApp

from app.cluster.alive import Alive
from app.cluster.beats import Beats
from app.cluster.hand_on import HandOn
from app.cluster.hand_over import HandOver
from app.cluster.line import Line
from app.cluster.membership import Member
from app.cluster.node import Node
from app.errors import SettingError
from app.listening import address_of
from app.persistence.ledger.database import address
from app.web.services import Services
from app.web.shared import Standing

_JOIN: Final = 5.0
"""s that a start waits for the table of members; then the server goes on, and is not ready."""


class Cluster:
    """What `app.main` starts and stops, and what routes know of the other servers."""

    def __init__(self, server: Services) -> None:
        settings, holding = server.settings, server.rooms.holding
        assert holding is not None, "a cluster has a shared ledger"
        if settings.address and not settings.address.startswith(("http://", "https://")):
            raise SettingError(
                f"address={settings.address!r} is not an address such as http://10.0.0.1:8000",
                field="address",
            )
        self.name = settings.name
        self._host = settings.host
        self._holds = holding.holds
        self._holds.address = settings.address.rstrip("/")
        self._line = Line()
        self._alive = Alive(Beats(address(settings.ledger_url)), self._holds, self.name)
        self._hand_over = HandOver(self._alive, holding, self._line, watched=server.hub.count)
        self._node = Node(
            self._alive,
            self._hand_over,
            holding,
            server.ledger,
            self._line,
            has=server.rooms.is_open,
        )
        server.others = self

    @property
    def middleware(self) -> "functools.partial[HandOn]":
        """What brings each request to the server that has its room."""
        return functools.partial(_hand_on, node=self._node)

    def listens(self, listener: socket.socket) -> None:
        """It listens here: unless it was told another address, the others reach it there."""
        port = listener.getsockname()[1]
        here = address_of(listener).rstrip("/")
        everywhere = self._host in ("0.0.0.0", "::", "")
        found = f"http://{socket.gethostname()}:{port}" if everywhere else here
        self._holds.address = self._holds.address or found

    async def run(self) -> None:
        """Be one of the servers until cancelled.

        Beats go by themselves: a ledger that takes its time must not cost this server its lease.
        """
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._alive.run())
            tasks.create_task(self._node.run())

    async def until_joined(self) -> None:
        """Return once the others know of this server, or it is clear that this takes long."""
        try:
            async with asyncio.timeout(_JOIN):
                while not self.joined:
                    await self._alive.until_looked()
        except TimeoutError:
            return

    async def gone(self) -> None:
        """This server has ended."""
        await self._alive.gone()
        await self._node.gone()

    # What routes ask.

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self._alive.joined

    def standing(self) -> Standing:
        """How this server stands among the others."""
        view = self._alive.view
        names = sorted(each.name for each in view.members.values())
        counts = (self._node.taken_over, self._hand_over.count, self._node.handed_on)
        return Standing(self.name, view.up, names, len(self._holds.rooms), *counts)

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        return await self._hand_over.move(room_id, to)

    async def leave(self) -> None:
        """Give all rooms to the others."""
        await self._hand_over.leave()

    async def ask_all(self, path: str, part: str) -> list[Any]:
        """What each of the others lists as `part` of its answer to a GET of this path."""
        me, members = self._holds.holder, self._alive.view.members.values()
        others = [each for each in members if each.holder != me]
        return list(await asyncio.gather(*(self._line.ask(each, path, part) for each in others)))


def _hand_on(app: ASGIApp, node: Node) -> HandOn:
    return HandOn(app, node)
