"""Connections to the other servers: requests handed on, rooms offered, lists asked for."""

import asyncio
import contextlib
from typing import Final
from urllib.parse import quote

import httpx

from app.cluster.membership import Member
from app.web.problems import HOPS

_CONNECT: Final = 1.0  # s
_ANSWER: Final = 2.0
"""s for an answer to this server itself: a list, or a room that is back at the other server before
its clients are sent there."""


class Peers:
    """For the event loop's thread. `handed_on` counts requests and WebSockets."""

    def __init__(self, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self.handed_on = 0
        # Shorter than a server keeps a silent connection: it must not end as a request is sent.
        limits = httpx.Limits(max_connections=None, keepalive_expiry=2.0)
        timeout = httpx.Timeout(None, connect=_CONNECT)
        self.http = httpx.AsyncClient(
            timeout=timeout, limits=limits, trust_env=False, transport=transport
        )

    async def have_taken(self, member: Member, room_id: str) -> None:
        """Have another server take a room that was given to it; if it does not, it will later."""
        await self._get(member, f"/api/v1/rooms/{quote(room_id, safe='')}")

    async def ask(self, member: Member, path: str, part: str) -> list[object]:
        """What another server lists as `part` of its answer to a GET, on the first page."""
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
