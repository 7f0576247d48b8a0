"""A WebSocket handed on to the server that has its room: all is passed on, both ways."""

import asyncio
import contextlib
from typing import Final
from urllib.parse import urlsplit

from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from app.cluster.http_line import Outcome, headers_for, without
from app.cluster.membership import Member
from app.cluster.node import Node
from app.relay.line import GONE, RESTART, both_ways

_OPEN: Final = 2.0  # s for the other server to answer

_CLOSE: Final = 1.0  # s for it to hear that the client has left

_OF_THE_HANDSHAKE: Final = frozenset(
    (
        b"host",
        b"origin",  # was found good here
        b"user-agent",
        b"sec-websocket-key",
        b"sec-websocket-version",
        b"sec-websocket-extensions",
        b"sec-websocket-protocol",
    )
)


async def pass_socket(
    node: Node, member: Member, scope: Scope, receive: Receive, send: Send, hops: int
) -> Outcome:
    """Have `member` talk to a client until one of them ends, unless it does not answer."""
    at = urlsplit(member.address)
    query = scope["query_string"].decode("latin-1")
    path = scope["raw_path"].partition(b"?")[0].decode("latin-1")
    host = dict(scope["headers"]).get(b"host", b"localhost").decode("latin-1")
    scheme = "wss" if at.scheme == "https" else "ws"
    headers = without(headers_for(scope, hops), _OF_THE_HANDSHAKE)
    try:
        room = await connect(
            f"{scheme}://{host}{path}{f'?{query}' if query else ''}",
            host=at.hostname,
            port=at.port or (443 if scheme == "wss" else 80),
            additional_headers=[(n.decode("latin-1"), v.decode("latin-1")) for n, v in headers],
            user_agent_header=None,
            compression=None,
            max_size=None,
            proxy=None,
            ping_interval=None,
            open_timeout=_OPEN,
            close_timeout=_CLOSE,
        )
    except ConnectionRefusedError:
        return Outcome.SILENT
    except (OSError, InvalidHandshake, ConnectionClosed, TimeoutError):
        return Outcome.AGAIN
    async with room:
        with node.hand_over.passed.line() as closing:
            await _talk(node, member, WebSocket(scope, receive, send), room, closing)
    return Outcome.DONE


async def _talk(
    node: Node, member: Member, client: WebSocket, room: ClientConnection, closing: asyncio.Event
) -> None:
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await client.accept()
        talking = asyncio.create_task(both_ways(client, room))
        ending = asyncio.create_task(node.alive.until_gone(member))
        leaving = asyncio.create_task(closing.wait())
        tasks = (talking, ending, leaving)
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            # Without a word: its server or this one ends, and the room is had over another.
            code = room.close_code or GONE
            reason = room.close_reason or "the room is brought to another server"
            await client.close(RESTART if code in (GONE, 1005) else code, reason)
