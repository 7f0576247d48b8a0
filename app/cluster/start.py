"""Puts this server's end of the cluster together; imported where one is asked for."""

import asyncio
import functools
import socket
from typing import Final

from starlette.types import ASGIApp

from app.cluster.hand_on import HandOn
from app.cluster.leases import Leases
from app.cluster.line import Line
from app.cluster.node import Node
from app.errors import SettingError
from app.listening import address_of
from app.web.services import Services

_JOIN: Final = 5.0
"""s that a start waits for the lease store; then the server goes on without, and is not ready."""


_LOOK: Final = 0.02  # s between two looks


class Cluster:
    """What `app.main` starts and stops."""

    def __init__(self, server: Services) -> None:
        settings, holding = server.settings, server.rooms.holding
        assert holding is not None, "a cluster has a shared ledger"
        if settings.address and not settings.address.startswith(("http://", "https://")):
            raise SettingError(
                f"address={settings.address!r} is not an address such as http://10.0.0.1:8000",
                field="address",
            )
        holding.holds.address = settings.address.rstrip("/")
        self._host = settings.host
        self._name = settings.name or f"{socket.gethostname()}-{settings.port}"
        self.node = Node(
            Leases(settings.cluster),
            holding,
            server.ledger,
            Line(),
            self._name,
            has=server.rooms.is_open,
            watched=server.hub.count,
        )
        server.others = self.node

    @property
    def middleware(self) -> "functools.partial[HandOn]":
        """What brings each request to the server that has its room."""
        return functools.partial(_hand_on, node=self.node)

    def listens(self, listener: socket.socket) -> None:
        """It listens here: unless it was told another address, the others reach it there."""
        port = listener.getsockname()[1]
        here = address_of(listener).rstrip("/")
        everywhere = self._host in ("0.0.0.0", "::", "")
        self.node.at(f"http://{socket.gethostname()}:{port}" if everywhere else here)

    async def run(self) -> None:
        """Be one of the servers until cancelled."""
        await self.node.run()

    async def joined(self) -> None:
        """Return once the others know of this server, or it is clear that this takes long."""
        for _ in range(int(_JOIN / _LOOK)):
            if self.node.joined:
                return
            await asyncio.sleep(_LOOK)

    async def gone(self) -> None:
        """This server has ended."""
        await self.node.gone()


def _hand_on(app: ASGIApp, node: Node) -> HandOn:
    return HandOn(app, node)
