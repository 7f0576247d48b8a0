"""HTTP to the other servers: requests handed on, rooms offered, lists asked for."""

import asyncio
import contextlib
from typing import Any, Final
from urllib.parse import quote

import httpx

from app.cluster.membership import Member
from app.web.shared import HOPS

MOST_HOPS: Final = 3
"""So often at most; who gets it then answers, or says that the room is not there."""

_CONNECT: Final = 1.0  # s
_TAKE: Final = 2.0
"""s that a room may take to come back at the other server, before who watches is sent there."""
_ASK: Final = 2.0  # s


class Line:
    """Connections to the other servers, kept for the next request."""

    def __init__(self) -> None:
        # Shorter than a server keeps a silent connection: it must not end as a request is sent.
        limits = httpx.Limits(max_connections=None, keepalive_expiry=2.0)
        self.http = httpx.AsyncClient(
            timeout=httpx.Timeout(None, connect=_CONNECT),
            limits=limits,
            trust_env=False,
            follow_redirects=False,
        )

    async def close(self) -> None:
        """Close them all."""
        await self.http.aclose()

    async def have_taken(self, member: Member, room_id: str) -> None:
        """Have another server take a room that nobody has; if it does not, somebody else will."""
        await self._get(member, f"/api/v1/rooms/{quote(room_id, safe='')}", _TAKE)

    async def ask(self, member: Member, path: str, part: str) -> list[Any]:
        """What another server lists as `part` of its answer to a GET, page by page."""
        found: list[Any] = []
        after: str | None = ""
        while after is not None:
            query = f"?after={quote(after)}" if after else ""
            answer = await self._get(member, f"{path}{query}", _ASK)
            if answer is None or answer.status_code != 200:
                return found
            page = answer.json()
            found += page[part]
            after = page["next"]
        return found

    async def _get(self, member: Member, path: str, seconds: float) -> httpx.Response | None:
        with contextlib.suppress(httpx.HTTPError, TimeoutError):
            async with asyncio.timeout(seconds):
                return await self.http.get(
                    f"{member.address}{path}",
                    headers={HOPS: str(MOST_HOPS), "host": "localhost"},
                )
        return None
