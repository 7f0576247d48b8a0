"""A line of one's own to the room's process, for who does more than watch: all is passed on."""

import asyncio
import contextlib
from urllib.parse import quote, urlsplit

from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

from app.errors import SettingError

RESTART = 1012  # RFC 6455: come back later
_WITHOUT_A_WORD = (None, 1005, 1006)  # not to be sent


def address(rooms: str, room_id: str, query: str) -> str:
    """Where a room's WebSocket is, from its server's address; SettingError for what is none."""
    parts = urlsplit(rooms)
    scheme = {"http": "ws", "https": "wss"}.get(parts.scheme)
    if scheme is None or not parts.hostname:
        raise SettingError(f"rooms={rooms!r} is not an address such as http://127.0.0.1:8000")
    path = f"{parts.path.rstrip('/')}/ws/rooms/{quote(room_id, safe='')}"
    return f"{scheme}://{parts.netloc}{path}{f'?{query}' if query else ''}"


async def talk(socket: WebSocket, url: str, first: str | None) -> None:
    """Pass everything on, both ways, from `first` on, until one side ends; then end the other."""
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
        code, reason = RESTART, f"the room's process does not answer: {type(error).__name__}"
    with contextlib.suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(code, reason)


def end_of(room: ClientConnection) -> tuple[int, str]:
    """The code and the reason with which to end a client, as the room's process has ended."""
    code = room.close_code
    return RESTART if code in _WITHOUT_A_WORD else code, room.close_reason or ""


async def both_ways(socket: WebSocket, room: ClientConnection) -> None:
    """Pass everything on, both ways, until one side ends."""
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
