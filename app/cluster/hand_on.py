"""Brings each request to the server that has its room; for the client there is one server."""

import asyncio
import contextlib
import time
from typing import Final

import msgspec
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.cluster.body import Body
from app.cluster.http_line import Outcome, pass_http
from app.cluster.line import MOST_HOPS
from app.cluster.membership import Member
from app.cluster.node import Node
from app.cluster.socket_line import pass_socket
from app.errors import AppError, EndedError, HoldLostError, LedgerError, shorten
from app.relay.line import RESTART
from app.web.problems import MOVED, problem_response
from app.web.shared import HOPS

_ROOMS: Final = ("/api/v1/rooms/", "/ws/rooms/")
_SESSIONS: Final = "/api/v1/sessions/"
_NAMED_INSIDE: Final = ("/api/v1/sessions", "/api/v1/halts")
"""Paths of requests whose body names the room."""

_PATIENCE: Final = 8.0  # s that a request waits for a room that is on its way
_PAUSE: Final = 0.05  # s until it is tried again

_NOTHING_DONE: Final = (Outcome.AGAIN, Outcome.SILENT)


class _Named(msgspec.Struct):
    room: str | None = None


class HandOn:
    """Passes requests that are of a room to the server that has it, all others to this one.

    `app` answers here. A request is tried again as long as nothing was done about it: the room was
    on its way to another server.
    """

    def __init__(self, app: ASGIApp, node: Node) -> None:
        self.app = app
        self.node = node

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, here or there."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        hops = hops_of(scope)
        if scope["type"] == "websocket":
            await self._socket(scope, receive, send, hops)
            return
        body = Body(receive)
        room_id = room_of_path(scope["path"])
        if room_id is None:
            room_id = await self._room_inside(scope, body)
        if room_id is None:
            await self._anywhere(scope, body, send, hops)
            return
        await self._request(scope, body, send, room_id, hops)

    async def _anywhere(self, scope: Scope, body: Body, send: Send, hops: int) -> None:
        """Answer what is of no room: here, but rooms are made where they can stay."""
        made = scope["method"] == "POST" and scope["path"] == "/api/v1/rooms"
        if made and self.node.alive.leaving and hops < MOST_HOPS:
            for member in self.node.alive.others:
                if await pass_http(self.node, member, scope, body, send, hops) is Outcome.DONE:
                    return
        await self.app(scope, body.again(), send)

    async def _room_inside(self, scope: Scope, body: Body) -> str | None:
        """The room of a request whose path does not say it."""
        path: str = scope["path"]
        if scope["method"] == "POST" and path in _NAMED_INSIDE:
            return room_of_body(await body.whole())
        if path.startswith(_SESSIONS):
            with contextlib.suppress(LedgerError):
                session_id = path.removeprefix(_SESSIONS).partition("/")[0]
                return await self.node.room_of_session(session_id)
        return None

    async def _request(self, scope: Scope, body: Body, send: Send, room_id: str, hops: int) -> None:
        end = time.monotonic() + _PATIENCE
        outcome = Outcome.AGAIN
        while outcome in _NOTHING_DONE and time.monotonic() < end:
            member = await self._locate(room_id, hops)
            if member is None:
                outcome = await self._here(scope, body, send, last=hops >= MOST_HOPS)
            else:
                self.node.handed_on += 1
                outcome = await pass_http(self.node, member, scope, body, send, hops)
            await self._pause(outcome)
        if outcome is not Outcome.DONE:
            await problem_response(_why(outcome, room_id), scope["path"])(scope, body.again(), send)

    async def _locate(self, room_id: str, hops: int) -> Member | None:
        """Who has a room; this server, where that cannot be told: it then says why."""
        if self.node.has(room_id):
            return None
        try:
            return await self.node.locate(room_id, only_here=hops >= MOST_HOPS)
        except AppError:
            return None

    async def _here(self, scope: Scope, body: Body, send: Send, *, last: bool) -> Outcome:
        """Have this server answer; AGAIN where it says that the room has left."""
        moved = False

        async def unless_moved(message: Message) -> None:
            nonlocal moved
            if message["type"] == "http.response.start" and message["status"] == 503:
                moved = not last and MOVED in Headers(raw=message["headers"])
            if not moved:
                await send(message)

        await self.app(dict(scope), body.again(), unless_moved)
        return Outcome.AGAIN if moved else Outcome.DONE

    async def _socket(self, scope: Scope, receive: Receive, send: Send, hops: int) -> None:
        room_id = room_of_path(scope["path"])
        if room_id is not None:
            end = time.monotonic() + _PATIENCE
            while time.monotonic() < end:
                member = await self._locate(room_id, hops)
                if member is None:
                    break
                if hops and self.node.alive.leaving:
                    # A line over this server would end with it: the other one looks again.
                    await send({"type": "websocket.close", "code": RESTART, "reason": ""})
                    return
                self.node.handed_on += 1
                outcome = await pass_socket(self.node, member, scope, receive, send, hops)
                if outcome is Outcome.DONE:
                    return
                await self._pause(outcome)
        await self.app(scope, receive, send)

    async def _pause(self, outcome: Outcome) -> None:
        """Until it is tried again: of a server that is silent, not before more is known."""
        if outcome is Outcome.SILENT:
            await self.node.alive.until_looked()
        elif outcome is Outcome.AGAIN:
            await asyncio.sleep(_PAUSE)


def _why(outcome: Outcome, room_id: str) -> AppError:
    """What a client is told that got no answer."""
    name = shorten(room_id)
    if outcome in _NOTHING_DONE:
        return HoldLostError(f"room {name} is on its way to another server", field="room")
    return EndedError(
        f"the server that had room {name} ended before it answered; whether it did what was asked "
        "is seen in the room"
    )


def hops_of(scope: Scope) -> int:
    """How often a request was handed on before; what is no number is often enough."""
    text = Headers(scope=scope).get(HOPS, "0")
    return int(text) if text in ("0", "1", "2") else MOST_HOPS


def room_of_path(path: str) -> str | None:
    """The room that a path is of, if any."""
    for begin in _ROOMS:
        if path.startswith(begin):
            return path.removeprefix(begin).partition("/")[0] or None
    return None


def room_of_body(body: bytes) -> str | None:
    """The room that a body names, if any."""
    try:
        return msgspec.json.decode(body, type=_Named).room or None
    except (msgspec.DecodeError, UnicodeDecodeError):
        return None
