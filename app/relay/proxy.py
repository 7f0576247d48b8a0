"""Proxies a client's WebSocket to the room's server, for clients that do more than watch."""

import asyncio
import contextlib
from urllib.parse import quote, urlsplit

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from plinko.app.errors import SettingError

RESTART = 1012  # "service restart" (IANA's registry of close codes): reconnect later
_NO_CODE = (None, 1005, 1006)  # a connection that ended without a close code; not to be sent


def address(rooms: str, room_id: str, query: str) -> str:
    """The URL of a room's WebSocket, from its server's address; raises SettingError."""
    parts = urlsplit(rooms)
    scheme = {"http": "ws", "https": "wss"}.get(parts.scheme)
    if scheme is None or not parts.hostname:
        raise SettingError(f"rooms={rooms!r} is not an address such as http://127.0.0.1:8000")
    path = f"{parts.path.rstrip('/')}/ws/rooms/{quote(room_id, safe='')}"
    return f"{scheme}://{parts.netloc}{path}{f'?{query}' if query else ''}"


async def talk(socket: WebSocket, url: str, first: str | None) -> None:
    """Send `first` to the room, proxy both ways until one side closes, then close the other."""
    client = socket.client
    headers = {"X-Forwarded-For": client.host} if client else {}
    try:
        async with connect(
            url, additional_headers=headers, compression=None, max_size=None, proxy=None
        ) as room:
            if first is not None:
                await room.send(first)
            await both_ways(socket, room)
            code, reason = end_of(room)
    except (OSError, InvalidHandshake, ConnectionClosed, TimeoutError) as error:
        code, reason = RESTART, f"the room's server does not answer: {type(error).__name__}"
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(code, reason)


def end_of(room: ClientConnection) -> tuple[int, str]:
    """Close code and reason for the client, taken from the closed connection to the room."""
    code = room.close_code
    return RESTART if code in _NO_CODE else code, room.close_reason or ""


async def both_ways(socket: WebSocket, room: ClientConnection) -> None:
    """Forward messages in both directions until one side closes."""
    tasks = [asyncio.create_task(_down(room, socket)), asyncio.create_task(_up(socket, room))]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        outcomes = await asyncio.gather(*tasks, return_exceptions=True)
    for ended in outcomes:
        if isinstance(ended, Exception) and not isinstance(
            ended, ConnectionClosed | WebSocketDisconnect
        ):
            raise ended


async def _down(room: ClientConnection, socket: WebSocket) -> None:
    async for message in room:
        if isinstance(message, str):
            await socket.send_text(message)
        else:
            await socket.send_bytes(message)


async def _up(socket: WebSocket, room: ClientConnection) -> None:
    while (message := await socket.receive())["type"] != "websocket.disconnect":
        text = message.get("text")
        await room.send(message["bytes"] if text is None else text)
