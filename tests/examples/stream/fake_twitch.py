"""Twitch as the stream kit sees it: signing in, Helix, and EventSub over a WebSocket.

After the public descriptions: dev.twitch.tv/docs/authentication/getting-tokens-oauth (device code
flow), dev.twitch.tv/docs/eventsub/handling-websocket-events, dev.twitch.tv/docs/api/reference.
"""

import contextlib
import uuid
from collections import deque
from collections.abc import AsyncIterator
from typing import Any, Final

from aiohttp import WSCloseCode, web

CLIENT: Final = {"client_id": "client", "client_secret": "secret"}
USER: Final = {"id": "1", "login": "show", "display_name": "Show"}
PICTURE: Final = b"\x89PNG\r\n\x1a\n"
KEEPALIVE: Final = 10  # s
UNSURE: Final = 200
"""Messages of a connection that may be lost with it, so that Twitch sends them again."""

_SCOPES: Final = (
    "user:read:chat user:write:chat bits:read channel:read:subscriptions channel:read:redemptions"
)


class FakeTwitch:
    """It sends what the test tells it to; a kit that is away gets it later, or twice."""

    def __init__(self) -> None:
        self.port = 0
        self.said: list[str] = []  # in the chat
        self.tokens: list[str] = []  # the last one is valid
        self.waits = 1  # polls until the streamer has entered the code
        self.signed_in = 0
        self.broken_renewals = 0  # of tokens, that fail before the next one
        self.closes_former = True  # connection, once its subscriptions have moved
        self.subscribed: set[str] = set()  # types, of the connection
        self.subscriptions = 0  # requests
        self._socket: web.WebSocketResponse | None = None  # of the session with subscriptions
        self._sessions: dict[str, web.WebSocketResponse] = {}
        self._moving: set[str] = set()  # sessions to which the subscriptions move
        self._waiting: list[dict[str, Any]] = []
        self._sent: deque[dict[str, Any]] = deque(maxlen=UNSURE)
        self._runner: web.AppRunner | None = None
        self._site: web.TCPSite | None = None

    @property
    def rules(self) -> str:
        """The table of a kit's rules that leads it here."""
        home = f"127.0.0.1:{self.port}"
        return (
            f'[twitch]\nclient_id = "client"\nclient_secret = "secret"\napi = "http://{home}/helix/"\n'
            f'auth = "http://{home}/oauth2/"\nsocket = "ws://{home}/ws"\n'
        )

    @property
    def connections(self) -> int:
        return len(self._sessions)

    async def start(self) -> None:
        """At the same port each time."""
        application = web.Application()
        application.add_routes([
            web.post("/oauth2/device", self._device), web.post("/oauth2/token", self._token),
            web.get("/oauth2/validate", self._validate), web.get("/helix/users", self._users),
            web.post("/helix/eventsub/subscriptions", self._subscribe),
            web.post("/helix/chat/messages", self._chat), web.get("/ws", self._connect),
            web.get("/ada-50x50.png", self._picture),
        ])  # fmt: skip
        self._runner = web.AppRunner(application, access_log=None, shutdown_timeout=0.0)
        await self._runner.setup()
        self._site = web.TCPSite(self._runner, "127.0.0.1", self.port)
        await self._site.start()
        self.port = self._runner.addresses[0][1]

    async def kill(self) -> None:
        """Cut all connections, without a word."""
        assert self._site is not None
        assert self._runner is not None
        assert self._runner.server is not None
        await self._site.stop()
        for connection in self._runner.server.connections:
            if connection.transport is not None:
                connection.transport.abort()
        self._lost()
        await self._runner.cleanup()

    async def send(self, kind: str, number: str | None = None, **event: Any) -> None:
        """Send an event, now or once somebody listens to it."""
        about = {
            "message_id": number or str(uuid.uuid4()), "message_type": "notification",
            "message_timestamp": "2026-11-28T12:00:00Z", "subscription_type": kind,
            "subscription_version": "1",
        }  # fmt: skip
        subscription = {"type": kind, "version": "1", "status": "enabled"}
        self._waiting.append(
            {"metadata": about, "payload": {"subscription": subscription, "event": event}}
        )
        await self._flush()

    async def chat(self, name: str, text: str, *badges: str, number: str | None = None) -> None:
        user = {"chatter_user_id": f"id of {name}", "chatter_user_name": name}
        sets = [{"set_id": badge, "id": "1", "info": ""} for badge in badges]
        message = {"text": text, "fragments": [{"type": "text", "text": text}]}
        about: dict[str, Any] = {**user, "badges": sets, "color": "#E91E63", "message": message}
        await self.send("channel.chat.message", number, **about, message_type="text")

    async def move(self) -> None:
        """Ask the kit to go on at another connection, as Twitch does when a server restarts."""
        assert self._socket is not None
        session = {
            "id": str(uuid.uuid4()),
            "status": "reconnecting",
            "keepalive_timeout_seconds": None,
        }
        self._moving.add(session["id"] or "")
        session["reconnect_url"] = f"ws://127.0.0.1:{self.port}/ws?session={session['id']}"
        await self._socket.send_json(_message("session_reconnect", session))

    async def _flush(self) -> None:
        while self._waiting and self._socket is not None and not self._socket.closed:
            message = self._waiting[0]
            if message["metadata"]["subscription_type"] not in self.subscribed:
                return
            try:
                await self._socket.send_json(message)
            except ConnectionError:
                return
            self._waiting.remove(message)
            self._sent.append(message)

    def _lost(self) -> None:
        """Keep for the next connection what may not have arrived at this one."""
        self._waiting[:0] = self._sent
        self._sent.clear()
        self._socket = None
        self.subscribed.clear()

    async def _connect(self, request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        session = request.query.get("session") or str(uuid.uuid4())
        self._sessions[session] = socket
        welcome = {"id": session, "status": "connected", "keepalive_timeout_seconds": KEEPALIVE,
                   "reconnect_url": None}  # fmt: skip
        await socket.send_json(_message("session_welcome", welcome))
        if session in self._moving:
            before, self._socket = self._socket, socket
            assert before is not None
            if self.closes_former:
                await before.close(code=WSCloseCode.OK)
        await self._flush()
        while not socket.closed:
            try:
                await socket.receive(KEEPALIVE / 2)
                await socket.close(code=4001)  # a client that sends anything is cut off
            except TimeoutError:
                if self._socket is socket:
                    await socket.send_json(_message("session_keepalive", {}))
        del self._sessions[session]
        if self._socket is socket:
            self._lost()
        return socket

    async def _subscribe(self, request: web.Request) -> web.Response:
        if not self._is_signed(request, "Bearer"):
            return web.json_response({"status": 401, "message": "Invalid OAuth token"}, status=401)
        asked = await request.json()
        socket = self._sessions.get(asked["transport"]["session_id"])
        if socket is None:
            return web.json_response({"status": 400, "message": "no such session"}, status=400)
        assert asked["condition"]["broadcaster_user_id"] == USER["id"]
        self._socket = socket
        self.subscribed.add(asked["type"])
        self.subscriptions += 1
        await self._flush()
        return web.json_response({"data": [{**asked, "id": str(uuid.uuid4())}]}, status=202)

    async def _chat(self, request: web.Request) -> web.Response:
        if not self._is_signed(request, "Bearer"):
            return web.json_response({"status": 401, "message": "Invalid OAuth token"}, status=401)
        given = {**request.query, **(await request.json() if request.can_read_body else {})}
        assert len(given["message"]) <= 500
        self.said.append(given["message"])
        sent = {"message_id": str(uuid.uuid4()), "is_sent": True, "drop_reason": None}
        return web.json_response({"data": [sent]})

    async def _users(self, request: web.Request) -> web.Response:
        asked = request.query.get("id", USER["id"])
        picture = f"http://127.0.0.1:{self.port}/ada-300x300.png"
        return web.json_response({"data": [{**USER, "id": asked, "profile_image_url": picture,
                                            "created_at": "2016-12-14T20:32:28Z"}]})  # fmt: skip

    async def _picture(self, _: web.Request) -> web.Response:
        return web.Response(body=PICTURE, content_type="image/png")

    async def _device(self, request: web.Request) -> web.Response:
        assert set((await request.post())["scopes"].split()) == set(_SCOPES.split())  # type: ignore[union-attr]
        self.signed_in += 1
        return web.json_response({
            "device_code": "device", "user_code": "ABCDEFGH", "expires_in": 1800, "interval": 5,
            "verification_uri": "https://www.twitch.tv/activate",
        })  # fmt: skip

    async def _token(self, request: web.Request) -> web.Response:
        given = await request.post()
        if given["grant_type"] == "refresh_token" and self.broken_renewals:
            self.broken_renewals -= 1
            return web.Response(status=502, text="<html>proxy</html>", content_type="text/html")
        if given["grant_type"] == "refresh_token":
            known = (given["client_id"], given["client_secret"]) == tuple(CLIENT.values())
            if not known or given["refresh_token"] != f"refresh {len(self.tokens)}":
                failure = {"status": 400, "message": "Invalid refresh token"}
                return web.json_response(failure, status=400)
        elif self.waits:
            self.waits -= 1
            return web.json_response(
                {"status": 400, "message": "authorization_pending"}, status=400
            )
        self.tokens.append(f"token {len(self.tokens)}")
        return web.json_response({
            "access_token": self.tokens[-1], "refresh_token": f"refresh {len(self.tokens)}",
            "expires_in": 14124, "scope": _SCOPES.split(), "token_type": "bearer",
        })  # fmt: skip

    async def _validate(self, request: web.Request) -> web.Response:
        if not self._is_signed(request, "OAuth"):
            return web.json_response({"status": 401, "message": "invalid access token"}, status=401)
        return web.json_response({
            "client_id": CLIENT["client_id"], "login": USER["login"], "user_id": USER["id"],
            "scopes": _SCOPES.split(), "expires_in": 5520838,
        })  # fmt: skip

    def _is_signed(self, request: web.Request, scheme: str) -> bool:
        return request.headers.get("Authorization") == f"{scheme} {(self.tokens or [''])[-1]}"


def _message(kind: str, session: dict[str, Any]) -> dict[str, Any]:
    about = {"message_id": str(uuid.uuid4()), "message_type": kind, "message_timestamp": ""}
    return {"metadata": about, "payload": {"session": session}}


@contextlib.asynccontextmanager
async def fake_twitch() -> AsyncIterator[FakeTwitch]:
    twitch = FakeTwitch()
    await twitch.start()
    try:
        yield twitch
    finally:
        await twitch.kill()
