"""Twitch: events over EventSub's WebSocket, answers in the chat.

dev.twitch.tv/docs/eventsub describes the protocol. The library signs in and asks; the socket is
read here, because the library's own gives up after nine failed attempts.
"""

import asyncio
import json
import logging
import os
import sqlite3
from collections.abc import Iterator
from typing import Any

import aiohttp
from journal import Event, Journal
from rules import Twitch as Settings
from twitchAPI.oauth import CodeFlow
from twitchAPI.twitch import Twitch as Api
from twitchAPI.type import AuthScope, TwitchAPIException

SCOPES = [
    AuthScope.USER_READ_CHAT, AuthScope.USER_WRITE_CHAT, AuthScope.BITS_READ,
    AuthScope.CHANNEL_READ_SUBSCRIPTIONS, AuthScope.CHANNEL_READ_REDEMPTIONS,
]  # fmt: skip
POINTS = "channel.channel_points_custom_reward_redemption.add"
TYPES = ("channel.chat.message", "channel.cheer", "channel.subscribe",
         "channel.subscription.message", "channel.subscription.gift", POINTS)  # fmt: skip
FAULTS = (aiohttp.ClientError, TwitchAPIException, TimeoutError, OSError, LookupError)
PATIENCE = 15.0  # s for a request: the library waits for five minutes
TIMEOUT = aiohttp.ClientTimeout(total=PATIENCE)
PAUSE = 2.0  # s between two lines in the chat, and between two attempts
LINE = 450  # characters of a line

log = logging.getLogger("kit")


class Twitch:
    def __init__(self, journal: Journal, settings: Settings, http: aiohttp.ClientSession) -> None:
        self.journal, self.settings, self.http = journal, settings, http
        secret = settings.client_secret or os.environ.get("TWITCH_SECRET", "")
        self.api = Api(settings.client_id, secret, False, base_url=settings.api,
                       auth_base_url=settings.auth, session_timeout=TIMEOUT)  # fmt: skip
        self.api.user_auth_refresh_callback = self._keep
        self.user = ""

    async def run(self) -> None:
        """Listen and answer, for ever."""
        while not self.user:
            try:
                await self._sign_in()
            except FAULTS as error:
                log.warning("Twitch: cannot sign in: %s", error)
                await asyncio.sleep(PAUSE)
        async with asyncio.TaskGroup() as group:
            group.create_task(self._listen())
            group.create_task(self._say())

    async def _keep(self, *tokens: str) -> None:
        with self.journal.db:
            self.journal.put(twitch=tokens)

    async def _sign_in(self) -> None:
        tokens = self.journal.get("twitch")
        try:
            if tokens:
                async with asyncio.timeout(PATIENCE):
                    await self.api.set_user_authentication(tokens[0], SCOPES, tokens[1])
        except TwitchAPIException as error:
            log.warning("Twitch: sign in again: %s", error)
            tokens = None
        if not tokens:
            flow = CodeFlow(self.api, SCOPES, self.settings.auth)
            code, page = await flow.get_code()
            print(f"Open {page} and enter the code {code}", flush=True)
            tokens = await flow.wait_for_auth_complete()
            await self.api.set_user_authentication(tokens[0], SCOPES, tokens[1])
            await self._keep(*tokens)
        async for user in self.api.get_users():
            self.user = user.id

    async def _listen(self) -> None:
        while True:
            try:
                await self._read(self.settings.socket, subscribe=True)
            except FAULTS as error:
                log.warning("Twitch: %s", str(error) or type(error).__name__)
            await asyncio.sleep(PAUSE)

    async def _read(self, address: str, *, subscribe: bool) -> None:
        """Read a connection to its end, and the one that follows it."""
        patience, following = 15.0, None
        async with self.http.ws_connect(address) as socket:
            while True:
                frame = await socket.receive(patience)
                if frame.type is not aiohttp.WSMsgType.TEXT:
                    break
                message = json.loads(frame.data)
                about, payload = message["metadata"], message["payload"]
                if about["message_type"] == "session_welcome":
                    patience = payload["session"]["keepalive_timeout_seconds"] + 5.0
                    if subscribe:
                        await self._subscribe(payload["session"]["id"])
                elif about["message_type"] == "session_reconnect":
                    follower = self._read(payload["session"]["reconnect_url"], subscribe=False)
                    following = asyncio.create_task(follower)
                elif about["message_type"] == "notification":
                    self._notice(about, payload["event"])
                elif about["message_type"] == "revocation":
                    log.warning("Twitch: no longer sends %s", payload["subscription"]["type"])
        if following is not None:
            await following

    async def _subscribe(self, session: str) -> None:
        async with asyncio.timeout(PATIENCE):
            token = await self.api.get_refreshed_user_auth_token()
        headers = {"Client-Id": self.settings.client_id, "Authorization": f"Bearer {token}"}
        for kind in TYPES:
            condition = {"broadcaster_user_id": self.user}
            if kind == "channel.chat.message":
                condition["user_id"] = self.user
            body = {"type": kind, "version": "1", "condition": condition,
                    "transport": {"method": "websocket", "session_id": session}}  # fmt: skip
            path = f"{self.settings.api}eventsub/subscriptions"
            async with self.http.post(path, json=body, headers=headers) as reply:
                if reply.status in (400, 403):  # such as bits, for a channel that has none
                    log.warning("Twitch: this channel has no %s", kind)
                elif reply.status != 409:
                    reply.raise_for_status()

    def _notice(self, about: dict[str, Any], data: dict[str, Any]) -> None:
        for event in events_of(about["subscription_type"], about["message_id"], data):
            self.journal.take(event)

    async def avatar(self, user: str) -> str:
        """The address of a viewer's picture, or nothing."""
        platform, _, number = user.partition(":")
        if platform == "twitch" and number and self.user:
            async for each in self.api.get_users(user_ids=[number]):
                return str(each.profile_image_url).replace("300x300", "50x50")
        return ""

    async def _say(self) -> None:
        """Send the answers that wait, as many as fit, as one line."""
        while True:
            rows: list[sqlite3.Row] = []
            line = ""
            for row in self.journal.posted("say"):
                text = json.loads(row["data"])[:LINE]
                if rows and len(line) + len(text) + 3 > LINE:
                    break
                rows, line = [*rows, row], f"{line} · {text}" if line else text
            try:
                if rows:
                    await self.api.send_chat_message(self.user, self.user, line)
                    self.journal.done(rows)
            except FAULTS as error:
                log.warning("Twitch: cannot answer: %s", error)
            await asyncio.sleep(PAUSE)


def events_of(kind: str, number: str, data: dict[str, Any]) -> Iterator[Event]:
    """What the rules know of a notification."""
    name = data.get("chatter_user_name") or data.get("user_name") or "Anonymous"
    user = f"twitch:{data.get('chatter_user_id') or data.get('user_id') or ''}"
    words: dict[str, Any] = {"id": number, "name": name, "user": user, "source": "twitch"}
    if kind == "channel.chat.message":
        text = data["message"]["text"].strip()
        badges = {badge["set_id"] for badge in data["badges"]}
        if text.startswith("!"):
            command = text.split()[0].lower()
            yield Event(kind=command, text=text, colour=data["color"].lower(),
                        mod=bool(badges & {"broadcaster", "moderator"}), **words)  # fmt: skip
    elif kind == "channel.cheer":
        yield Event(kind="bits", amount=data["bits"], **words)
    elif kind in ("channel.subscribe", "channel.subscription.message"):
        if not data.get("is_gift"):  # a gift is an event of its own
            yield Event(kind="sub", **words)
    elif kind == "channel.subscription.gift":
        yield Event(kind="gift", amount=data["total"], **words)
    elif kind == POINTS:
        yield Event(kind=f"points:{data['reward']['title']}", text=data["user_input"], **words)
