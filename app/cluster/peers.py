"""HTTP connections to the other servers: forwarded requests, offered rooms, and queries."""

import asyncio
import contextlib
from typing import Final
from urllib.parse import quote

import httpx

from plinko.app.cluster.membership import Member
from plinko.app.web.problems import HOPS

_CONNECT: Final = 1.0  # s
_ANSWER: Final = 2.0
"""Seconds to wait for the answer to this server's own request: for a list, or until the other
server has restored a room, so that clients find it there."""


class Peers:
    """For the event loop's thread. `forwarded` counts requests and WebSockets."""

    def __init__(self, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self.forwarded = 0
        # Shorter than a server keeps an idle connection open, so that the server does not close a
        # connection just as a request is sent on it.
        limits = httpx.Limits(max_connections=None, keepalive_expiry=2.0)
        timeout = httpx.Timeout(None, connect=_CONNECT)
        self.http = httpx.AsyncClient(
            timeout=timeout, limits=limits, trust_env=False, transport=transport
        )

    async def have_taken(self, member: Member, room_id: str) -> None:
        """Ask another server to take the room handed over to it; without this it does so later."""
        await self._get(member, f"/api/v1/rooms/{quote(room_id, safe='')}")

    async def ask(self, member: Member, path: str, part: str) -> list[object]:
        """The list `part` in another server's answer to a GET (its first page); [] on failure."""
        answer = await self._get(member, path)
        listed: list[object] = [] if answer is None or answer.is_error else answer.json()[part]
        return listed

    async def _get(self, member: Member, path: str) -> httpx.Response | None:
        with contextlib.suppress(httpx.HTTPError, TimeoutError):
            async with asyncio.timeout(_ANSWER):
                return await self.http.get(
                    f"{member.address}{path}", headers={HOPS: "1", "host": "localhost"}
                )
        return None
