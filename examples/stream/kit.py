"""The stream kit: turns chat commands, bits, subs, gifts, points and donations into balls.

    python kit.py rules.toml

README.md next to this file says how to set it up. An event passes through this file from top to
bottom: Twitch or another program sends it, the journal writes it with the balls that the rules
give, the game drops them, and what their landings change is shown on the stage and in OBS.
"""
# pip install -r requirements.txt

import asyncio
import base64
import contextlib
import json
import logging
import math
import mimetypes
import os
import re
import secrets
import sqlite3
import sys
import time
import unicodedata
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Annotated, Any

import aiohttp
import msgspec
import simpleobsws
from aiohttp import web
from twitchAPI.oauth import CodeFlow
from twitchAPI.twitch import Twitch as TwitchApi
from twitchAPI.type import AuthScope, InvalidRefreshTokenException, TwitchAuthorizationException

MOST = 10_000  # balls of an event
TURN, PAUSE = 0.2, 2.0  # s between two looks at the journal; between two attempts
PATIENCE = 15.0  # s without a word from Twitch, which sends one every ten seconds
SILENCE = aiohttp.ClientTimeout(PATIENCE)
EFFECT, ANSWER, DAY = 30.0, 600.0, 86_400.0  # s after which what is posted is of no use any more
LINE = 450  # characters of a line in the chat
FACE = 1 << 12  # bytes: 25 of them fit into a show
GONE = (401, 403, 404)  # statuses of a room that is not ours any more
SCOPES = [
    AuthScope.USER_READ_CHAT, AuthScope.USER_WRITE_CHAT, AuthScope.BITS_READ,
    AuthScope.CHANNEL_READ_SUBSCRIPTIONS, AuthScope.CHANNEL_READ_REDEMPTIONS,
]  # fmt: skip
TYPES = ("channel.chat.message", "channel.cheer", "channel.subscribe",
         "channel.subscription.message", "channel.subscription.gift",
         "channel.channel_points_custom_reward_redemption.add")  # fmt: skip

log = logging.getLogger("kit")
faults: dict[str, str] = {}  # by part, while they last


async def forever(part: str, step: Callable[[], Awaitable[None]], pause: float) -> None:
    """Take a step again and again; what breaks is logged, once, and tried again."""
    while True:
        try:
            await step()
            faults.pop(part, None)
            await asyncio.sleep(pause)
        except* Exception as group:  # noqa: BLE001 - the show goes on
            error = group.exceptions[0]
            fault = str(error) or type(error).__name__
            if faults.get(part) != fault:
                log.warning("%s: %s", part, fault)
            faults[part] = fault
            await asyncio.sleep(PAUSE)


# The rules: one TOML file, parsed once.

Money = Annotated[float, msgspec.Meta(ge=0.01)]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Words = Annotated[str, msgspec.Meta(pattern=r"^([^{}]|\{(name|jackpot|bin|score)\})*$")]


class Part(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """A table of the rules."""


class GameRules(Part):
    server: str = "http://127.0.0.1:8000"
    board: str = "triangle-12-high"  # a preset, or a board's JSON file
    every: Positive = 0.3  # s between two balls
    falling: Annotated[int, msgspec.Meta(ge=1, le=100)] = 20  # balls at the same time
    journal: str = "kit.db"
    texts: str = ""  # the folder of the text files
    port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = 8020  # of the address for other programs


class TwitchRules(Part):
    client_id: str
    client_secret: str = ""  # or TWITCH_SECRET in the environment
    api: str = "https://api.twitch.tv/helix/"
    auth: str = "https://id.twitch.tv/oauth2/"
    socket: str = "wss://eventsub.wss.twitch.tv/ws"


class ObsRules(Part):
    address: str = "ws://127.0.0.1:4455"
    password: str = ""  # or OBS_PASSWORD in the environment
    stage: str = ""  # the browser source that shows the stage
    sounds: str = ""  # the media source that plays sounds
    folder: str = "sounds"  # of their files


class Effects(Part):
    timer: float = 0.0  # s added
    pause: bool | None = None  # stops the timer, or starts it again
    goals: dict[str, float] = {}  # added, by goal
    jackpot: float = 0.0  # added
    pay: bool = False  # the jackpot begins again
    again: Annotated[int, msgspec.Meta(ge=0, le=100)] = 0  # balls for the same viewer
    say: Words = ""
    scene: str = ""
    source: str = ""  # of the current scene
    seconds: Positive = 8.0  # until the former scene, or until the source is hidden
    sound: str = ""  # a file


class Input(Effects):
    balls: Annotated[int, msgspec.Meta(ge=0, le=1000)] = 1
    per: Money | None = None  # bits or money that `balls` cost; the rest is kept
    every: float = 0.0  # s for each viewer
    mods: bool = False  # only for moderators


class Landing(Effects):
    bin: list[int] | None = None
    label: str | None = None
    least: float = 0.0  # multipliers
    most: float = float("inf")

    def fits(self, landed: dict[str, Any]) -> bool:
        return (
            landed["bin"] is not None
            and (self.bin is None or landed["bin"] in self.bin)
            and self.label in (None, landed.get("label"))
            and self.least <= landed["score"] <= self.most
        )


class Figure(Part):
    start: float = 0.0
    label: str = ""
    unit: str = ""


class Goal(Part):
    target: Positive
    reached: Effects = msgspec.field(default_factory=Effects)


class Looks(Part):
    panel: str | None = None
    ink: str | None = None
    accent: str | None = None
    font: str | None = None
    logo: str | None = None  # a file
    options: str = ""  # of the stage's address
    faces: bool = True  # avatars and emoji as balls


class Rules(Part):
    game: GameRules = msgspec.field(default_factory=GameRules)
    twitch: TwitchRules | None = None
    obs: ObsRules | None = None
    inputs: dict[str, Input] = msgspec.field(default_factory=dict, name="in")
    timer: Figure | None = None
    jackpot: Figure | None = None
    goals: Annotated[dict[str, Goal], msgspec.Meta(max_length=4)] = {}
    landing: list[Landing] = []
    looks: Looks = msgspec.field(default_factory=Looks)

    def __post_init__(self) -> None:
        reached = (goal.reached for goal in self.goals.values())
        for effects in (*self.inputs.values(), *self.landing, *reached):
            for goal in effects.goals.keys() - self.goals.keys():
                raise ValueError(f'no goal has the name "{goal}": add [goals."{goal}"]')
        for name in self.inputs.keys() & {"bits", "donation"}:
            if self.inputs[name].per is None:
                raise ValueError(f"[in.{name}] needs `per`: how much a ball costs")


def read_rules(file: Path) -> Rules:
    """The rules; a mistake ends the program with the line from which on it is there."""
    lines, mistake, at = file.read_text("utf-8").splitlines(), "", 0
    for end in range(len(lines) + 1):
        try:
            rules, found = msgspec.toml.decode("\n".join(lines[:end]), type=Rules), ""
        except msgspec.ValidationError as error:
            found = str(error)
        except msgspec.DecodeError as error:
            if end == len(lines):
                sys.exit(f"{file}: {error}")  # it names the line
            continue  # a value of several lines
        if found != mistake:
            mistake, at = found, end
    if mistake:
        sys.exit(f"{file}, line {at}, {lines[at - 1].strip()}: {mistake}")
    return rules


class Event(msgspec.Struct):
    """What a viewer did: `kind` is a name in the rules, and `id` is the same in a repeat."""

    id: str
    kind: str
    name: str = ""
    user: str = ""  # the platform's id of the viewer
    amount: Annotated[float, msgspec.Meta(ge=0, le=1e9)] = 1.0
    text: str = ""
    colour: Annotated[str, msgspec.Meta(pattern="^(#[0-9a-fA-F]{6})?$")] = ""
    face: Annotated[str, msgspec.Meta(pattern="^(https?://.*|[^<>&:]{0,16})$")] = ""
    mod: bool = False


SCHEMA = """
PRAGMA journal_mode = WAL;
PRAGMA synchronous = FULL;
CREATE TABLE IF NOT EXISTS state (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS events (id TEXT PRIMARY KEY, kind TEXT, user TEXT, name TEXT,
    cents INTEGER, colour TEXT, text TEXT, face TEXT, time REAL, answer TEXT);
CREATE INDEX IF NOT EXISTS events_user ON events (user, kind);
CREATE TABLE IF NOT EXISTS balls (number INTEGER PRIMARY KEY, event TEXT,
    key TEXT DEFAULT (hex(randomblob(16))), bin INTEGER, score REAL, label TEXT, landed REAL);
CREATE INDEX IF NOT EXISTS balls_event ON balls (event);
CREATE INDEX IF NOT EXISTS balls_waiting ON balls (number) WHERE landed IS NULL;
CREATE TABLE IF NOT EXISTS faces (user TEXT PRIMARY KEY, face TEXT);
CREATE TABLE IF NOT EXISTS outbox (number INTEGER PRIMARY KEY, kind TEXT, data TEXT, due REAL,
    ends REAL);
"""


class Kit:
    """The journal, and all that writes into it or does what is written there.

    In the journal, an event has the id that its platform gave it, so a repeat is known; a ball
    has the key under which the game knows it. Events with their balls, and landings with all that
    they change, are one transaction each. Whatever is killed, no ball is lost or counted twice.
    """

    def __init__(self, rules: Rules, http: aiohttp.ClientSession) -> None:
        self.rules, self.http = rules, http
        self.db = sqlite3.connect(rules.game.journal, isolation_level=None)
        self.db.row_factory = sqlite3.Row
        self.db.executescript(SCHEMA)
        for name in ("secret", "address"):  # of requests to the game, of ours for programs
            self.put(name, self.get(name) or secrets.token_hex(16))
        self.twitch: TwitchApi | None = None  # signed in
        self.signing_in, self.choosing = asyncio.Lock(), asyncio.Lock()
        self.falling: set[int] = set()  # numbers of balls
        self.shown: object = None  # on the stage

    def rows(self, query: str, *values: object) -> list[sqlite3.Row]:
        return self.db.execute(query, values).fetchall()

    def get(self, name: str, default: Any = None) -> Any:
        found = self.rows("SELECT value FROM state WHERE name = ?", name)
        return json.loads(found[0]["value"]) if found else default

    def put(self, name: str, value: Any) -> None:
        self.db.execute("REPLACE INTO state VALUES (?, ?)", (name, json.dumps(value)))

    # Twitch.

    async def sign_in(self) -> TwitchApi:
        async with self.signing_in:
            if self.twitch:
                return self.twitch
            rules, name = self.rules.twitch, f"twitch {self.rules.twitch.client_id}"
            secret = rules.client_secret or os.environ.get("TWITCH_SECRET", "")
            twitch = TwitchApi(rules.client_id, secret, False, base_url=rules.api,
                               auth_base_url=rules.auth, session_timeout=SILENCE)  # fmt: skip
            twitch.auto_refresh_auth = False  # after one that fails, the next would wait for ever

            async def keep(*tokens: str) -> None:
                self.put(name, tokens)

            twitch.user_auth_refresh_callback = keep
            if not self.get(name):
                flow = CodeFlow(twitch, SCOPES, rules.auth)
                code, page = await flow.get_code()
                print(f"Open {page} and enter the code {code}", flush=True)
                await keep(*await flow.wait_for_auth_complete())
            token, refresh = self.get(name)
            try:
                async with asyncio.timeout(PATIENCE):
                    await twitch.set_user_authentication(token, SCOPES, refresh)
                    self.streamer = await anext(user.id async for user in twitch.get_users())
            except (InvalidRefreshTokenException, TwitchAuthorizationException):
                await keep()  # the streamer has to enter a code again
                raise
            self.twitch = twitch
            return twitch

    async def listen(self) -> None:
        """Take what Twitch sends over a connection, until it ends."""
        self.twitch = None  # its token may be of no use any more
        await self.sign_in()
        await self.read(self.rules.twitch.socket)

    async def read(self, address: str) -> None:
        """Read a connection to its end, and the one to which Twitch moves its subscriptions.

        The library's own reader loses subscriptions, without a word, if a connection breaks while
        it renews them.
        """
        timeout = aiohttp.ClientWSTimeout(ws_receive=PATIENCE)
        async with (
            asyncio.TaskGroup() as following,
            self.http.ws_connect(address, timeout=timeout) as socket,
        ):
            with contextlib.suppress(TimeoutError):  # silence is an end, too
                async for frame in socket:
                    message = json.loads(frame.data)
                    about, payload = message["metadata"], message["payload"]
                    match about["message_type"]:
                        case "session_welcome" if address == self.rules.twitch.socket:
                            await self.subscribe(payload["session"]["id"])
                        case "session_reconnect":
                            following.create_task(self.read(payload["session"]["reconnect_url"]))
                        case "notification":
                            self.notice(about, payload["event"])
                        case "revocation":
                            kind = payload["subscription"]["type"]
                            log.warning("Twitch: no longer sends %s", kind)

    async def subscribe(self, session: str) -> None:
        twitch = await self.sign_in()
        token, client = twitch.get_user_auth_token(), self.rules.twitch.client_id
        for kind in TYPES:
            condition = {"broadcaster_user_id": self.streamer}
            if kind == "channel.chat.message":
                condition["user_id"] = self.streamer
            async with self.http.post(
                f"{self.rules.twitch.api}eventsub/subscriptions",
                headers={"Client-Id": client, "Authorization": f"Bearer {token}"},
                json={"type": kind, "version": "1", "condition": condition,
                      "transport": {"method": "websocket", "session_id": session}},
            ) as reply:  # fmt: skip
                if reply.status in (400, 403):  # such as bits, for a channel that has none
                    log.warning("Twitch: this channel has no %s", kind)
                elif reply.status != 409:
                    reply.raise_for_status()

    def notice(self, about: dict[str, Any], data: dict[str, Any]) -> None:
        """Take a notification, if the rules know something of it."""
        user = data.get("chatter_user_id") or data.get("user_id") or ""
        name = data.get("chatter_user_name") or data.get("user_name") or "Anonymous"
        event = Event(about["message_id"], "", name, f"twitch:{user}")
        match about["subscription_type"]:
            case "channel.chat.message":
                event.text, event.colour = data["message"]["text"].strip(), data["color"]
                if event.text.startswith("!"):
                    event.kind = event.text.split()[0].lower()
                badges = {badge["set_id"] for badge in data["badges"]}
                event.mod = not badges.isdisjoint({"broadcaster", "moderator"})
            case "channel.cheer":
                event.kind, event.amount = "bits", data["bits"]
            case "channel.subscribe" | "channel.subscription.message":
                event.kind = "" if data.get("is_gift") else "sub"  # a gift is an event of its own
            case "channel.subscription.gift":
                event.kind, event.amount = "gift", data["total"]
            case _:
                event.kind, event.text = f"points:{data['reward']['title']}", data["user_input"]
        self.take(event)

    # The address for other programs.

    async def serve(self) -> None:
        application = web.Application()
        path = f"/{self.get('address')}/event"
        application.add_routes([web.get(path, self.hear), web.post(path, self.hear)])
        runner = web.AppRunner(application, access_log=None)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", self.rules.game.port).start()
        address = f"http://127.0.0.1:{runner.addresses[0][1]}{path}"
        print(f"Other programs send events to {address}", flush=True)

    async def hear(self, request: web.Request) -> web.Response:
        """An event from Streamer.bot and its like, in the query or as JSON."""
        given: dict[str, Any] = {"id": secrets.token_hex(16), **request.query}
        try:
            given |= msgspec.json.decode(await request.read() or b"{}", type=dict[str, Any])
            given["user"] = f"bridge:{given.get('user') or given.get('name', '')}"
            event = msgspec.convert(given, Event, strict=False)
            if math.isnan(event.amount):
                raise ValueError("amount: nan is not a number")
        except ValueError as error:
            return web.Response(status=422, text=f"{error}\n")
        balls = self.take(event)
        for _ in range(300 if given.get("wait") and balls else 0):
            answer = self.rows("SELECT answer FROM events WHERE id = ?", event.id)[0]["answer"]
            if answer:
                return web.Response(text=answer)
            await asyncio.sleep(TURN)
        return web.json_response({"balls": balls}, status=202)

    # An event becomes balls.

    def take(self, event: Event) -> int:
        """Write an event with its balls and effects, unless it is known; returns its balls."""
        inputs = self.rules.inputs
        rule = inputs.get(event.kind) or inputs.get(event.kind.partition(":")[0])
        if rule is None or (rule.mods and not event.mod):
            return 0
        now, cents = time.time(), round(100 * event.amount)
        with self.db:
            self.db.execute("BEGIN")
            paid, last = self.rows(
                "SELECT total(cents), max(time) FROM events "
                "WHERE user = ? AND kind = ? AND time IS NOT NULL", event.user, event.kind,
            )[0]  # fmt: skip
            waits = last is not None and now - last < rule.every
            added = self.db.execute(
                "INSERT OR IGNORE INTO events VALUES "
                "(:id, :kind, :user, :name, :cents, :colour, :text, :face, :time, NULL)",
                {**msgspec.structs.asdict(event), "cents": cents, "time": None if waits else now},
            )
            if added.rowcount and not waits:
                times = max(1, int(event.amount))
                if rule.per is not None:  # what earlier events have left counts
                    price = round(100 * rule.per)
                    times = int((paid + cents) // price - paid // price)
                self.add(event.id, min(rule.balls * times, MOST))
                self.apply(rule, event.id, {"name": event.name, "bin": "", "score": ""})
        return len(self.rows("SELECT 1 FROM balls WHERE event = ?", event.id))

    def add(self, event: str, balls: int) -> None:
        self.db.executemany("INSERT INTO balls (event) VALUES (?)", [(event,)] * balls)

    # The balls fall.

    async def ask(self, method: str, path: str, body: Any, key: str = "") -> dict[str, Any]:
        """The game's response; empty: it refuses the body."""
        headers = {"Authorization": f"Bearer {self.get('token')}"}
        if key:
            headers |= {"Idempotency-Secret": self.get("secret"), "Idempotency-Key": key}
        address = f"{self.rules.game.server}/api/v1/rooms{path}"
        async with self.http.request(method, address, json=body, headers=headers) as reply:
            found = msgspec.json.decode(await reply.read(), type=dict[str, Any])
        if reply.status == 422:
            log.warning("The game: %s", found["detail"])
            return {}
        if reply.status in GONE and path.startswith(f"/{self.get('room')}/"):
            self.put("room", None)  # before the next show, another one is opened
        if not reply.ok:
            raise OSError(found["detail"])
        return found

    async def open_room(self) -> None:
        board: Any = self.rules.game.board
        if board.endswith(".json"):
            board = json.loads(Path(board).read_text("utf-8"))
        reply = await self.ask("POST", "", {"board": board})
        if not reply:
            sys.exit("the game refuses the board")
        self.put("token", reply["token"])
        self.put("room", reply["id"])
        print(f"The stage is at {self.stage}", flush=True)

    @property
    def stage(self) -> str:
        """The address of the room's stage."""
        options = self.rules.looks.options
        return f"{self.rules.game.server}/stage.html?room={self.get('room')}&{options}".rstrip("&")

    async def drop(self) -> None:
        """Drop the next ball and wait for its landing. A repeat with its key is the same ball."""
        async with self.choosing:
            while not (ball := self.next_ball()):
                await asyncio.sleep(TURN)
            self.falling.add(ball["number"])
            await asyncio.sleep(self.rules.game.every)
        try:
            await self.find_face(ball)
            path = f"/{self.get('room')}/drops?wait=1"
            tag = {"name": clean(ball["name"]), "colour": ball["colour"].lower()}
            tag = {key: value for key, value in tag.items() if value}
            reply = await self.ask("POST", path, tag, ball["key"])
            if not reply:  # without the name that it refuses
                reply = await self.ask("POST", path, {}, ball["key"])
            if "landed" in reply:
                self.land(ball, reply["landed"])
        finally:
            self.falling.remove(ball["number"])

    def next_ball(self) -> sqlite3.Row | None:
        """The oldest ball that has not landed and is not falling, with its event."""
        rows = self.rows(
            "SELECT * FROM balls JOIN events ON events.id = balls.event WHERE landed IS NULL "
            "ORDER BY number LIMIT ?", self.rules.game.falling,
        )  # fmt: skip
        return next((row for row in rows if row["number"] not in self.falling), None)

    async def find_face(self, ball: sqlite3.Row) -> None:
        """Learn what a viewer's balls look like: an emoji after the command, or the avatar."""
        emoji = re.fullmatch(r"\S+\s+([^\w\s<>&:]{1,16})", ball["text"])
        known = self.rows("SELECT 1 FROM faces WHERE user = ?", ball["user"])
        if not self.rules.looks.faces or (known and not emoji):
            return
        face, number = emoji[1] if emoji else ball["face"], ball["user"].removeprefix("twitch:")
        try:
            async with asyncio.timeout(2.0):
                if self.twitch and not face and number not in ("", ball["user"]):
                    user = await anext(self.twitch.get_users(user_ids=[number]))
                    face = user.profile_image_url.replace("300x300", "50x50")
                if not face:
                    return
                if "://" in face:
                    async with self.http.get(face, raise_for_status=True) as reply:
                        data = await reply.content.read(FACE + 1)
                    face = picture(reply.url.path, data) if len(data) <= FACE else ""
        except Exception as error:  # noqa: BLE001 - the ball falls without it
            log.info("no avatar of %s: %s", ball["name"], error)
            return
        self.db.execute("REPLACE INTO faces VALUES (?, ?)", (ball["user"], face))

    # A landing changes something.

    def land(self, ball: sqlite3.Row, landed: dict[str, Any]) -> None:
        """Write a landing with all that it changes, unless it is known."""
        row = (landed["bin"], landed["score"], landed.get("label"), time.time(), ball["number"])
        words = {"name": ball["name"], "bin": landed["bin"], "score": f"{landed['score']:g}x"}
        with self.db:
            self.db.execute("BEGIN")
            written = self.db.execute(
                "UPDATE balls SET bin = ?, score = ?, label = ?, landed = ? "
                "WHERE number = ? AND landed IS NULL", row,
            )  # fmt: skip
            if written.rowcount:
                for rule in self.rules.landing:
                    if rule.fits(landed):
                        self.apply(rule, ball["event"], words)
                self.answer(ball)

    def apply(self, effects: Effects, event: str, words: dict[str, object]) -> None:
        """Change what an event or a landing changes; `words` are those that a line may have."""
        figures = self.figures()
        figures["left"] += effects.timer
        if effects.pause is not None:
            figures["running"] = not effects.pause
        figures["jackpot"] += effects.jackpot
        words = {**words, "jackpot": f"{figures['jackpot']:g}"}
        if effects.pay and self.rules.jackpot:
            figures["jackpot"] = self.rules.jackpot.start
        reached = []
        for name, more in effects.goals.items():
            before, goal = figures["goals"][name], self.rules.goals[name]
            figures["goals"][name] = before + more
            if before < goal.target <= before + more:
                reached.append(goal.reached)
        self.put("show", figures)
        self.add(event, effects.again)
        if effects.say:
            self.post("say", effects.say.format(**words), ANSWER)
        for kind in ("scene", "source", "sound"):
            if self.rules.obs and (name := getattr(effects, kind)):
                self.post("obs", [kind, name, effects.seconds], EFFECT)
        for each in reached:
            self.apply(each, event, words)

    def figures(self) -> dict[str, Any]:
        """Timer, jackpot and goals. `left`: seconds on the timer, at `time`."""
        timer, jackpot = self.rules.timer or Figure(), self.rules.jackpot or Figure()
        fresh = {"left": timer.start, "running": False, "jackpot": jackpot.start, "goals": {}}
        now = time.time()
        figures = {"time": now, **self.get("show", fresh)}
        figures["goals"] = dict.fromkeys(self.rules.goals, 0.0) | figures["goals"]
        if figures["running"]:
            figures["left"] -= now - figures["time"]
        return {**figures, "left": max(0.0, figures["left"]), "time": now}

    def answer(self, ball: sqlite3.Row) -> None:
        """Write to the viewer where the balls went, once all of them have landed."""
        balls, landed, total, score, best, label = self.rows(
            "SELECT count(*), count(landed), total(score), max(score), bin, label "
            "FROM balls WHERE event = ?", ball["event"],
        )[0]  # fmt: skip
        if landed < balls:
            return
        won = label or f"{score:g}x"  # by the best of them, as its bin is
        text = f"@{ball['name']} {won} (bin {best})"
        if balls > 1:
            text = f"@{ball['name']} {balls} balls: {total:g}x, the best {won}"
        self.db.execute("UPDATE events SET answer = ? WHERE id = ?", (text, ball["event"]))
        self.put("last", text)
        if ball["user"].startswith("twitch:"):
            self.post("say", text, ANSWER)

    # What waits for the chat and for OBS.

    def post(self, kind: str, data: Any, keep: float, after: float = 0.0) -> None:
        """Have something done some seconds after this, at least once, unless it is too late."""
        now = time.time()
        self.db.execute("DELETE FROM outbox WHERE ends < ?", (now,))
        row = (kind, json.dumps(data), now + after, now + after + keep)
        self.db.execute("INSERT INTO outbox (kind, data, due, ends) VALUES (?, ?, ?, ?)", row)

    def posted(self, kind: str) -> list[tuple[int, Any]]:
        """Numbers and data of the oldest of this kind that are due and not too late."""
        rows = self.rows(
            "SELECT number, data FROM outbox WHERE kind = ? AND ? BETWEEN due AND ends "
            "ORDER BY number LIMIT 20", kind, time.time(),
        )  # fmt: skip
        return [(row["number"], json.loads(row["data"])) for row in rows]

    def done(self, number: int) -> None:
        self.db.execute("DELETE FROM outbox WHERE number = ?", (number,))

    async def say(self) -> None:
        """Send the lines for the chat that wait, as many as fit, as one."""
        posted = self.posted("say")
        while len(line := " · ".join(text[:LINE] for _, text in posted)) > LINE:
            posted.pop()
        if posted:
            twitch = await self.sign_in()
            self.twitch = None  # after an error, it is of no use
            await twitch.send_chat_message(self.streamer, self.streamer, line)
            self.twitch = twitch
            for number, _ in posted:
                self.done(number)

    # The stage.

    async def show(self) -> None:
        """Send timer, goals, jackpot, looks and faces to the stage, if they have changed."""
        rules, figures = self.rules, self.figures()
        if not self.get("room"):
            await self.open_room()
        faces = self.rows(
            "SELECT DISTINCT name, faces.face FROM balls JOIN events ON events.id = balls.event "
            "JOIN faces USING (user) WHERE faces.face <> '' AND landed IS NULL "
            "ORDER BY number LIMIT 25"
        )
        show: dict[str, Any] = {"faces": {clean(name): face for name, face in faces}}
        show["looks"] = msgspec.to_builtins(rules.looks)
        del show["looks"]["options"], show["looks"]["faces"]
        if logo := rules.looks.logo:
            show["looks"]["logo"] = picture(logo, Path(logo).read_bytes())
        show["goals"] = [
            {"label": name, "value": figures["goals"][name], "target": goal.target}
            for name, goal in rules.goals.items()
        ]
        if rules.timer:
            left, running = figures["left"], figures["running"]
            show["timer"] = {"left": left, "label": rules.timer.label, "running": running}
        if pot := rules.jackpot:
            show["jackpot"] = {"value": figures["jackpot"], "label": pot.label, "unit": pot.unit}
        # A running timer counts on at the stage.
        news = (self.get("room"), self.get("show"), show["faces"])
        if news != self.shown:
            await self.ask("PUT", f"/{self.get('room')}/show", show)
            self.shown = news

    async def write(self) -> None:
        """Write the text files that have changed."""
        figures = self.figures()
        left = math.ceil(figures["left"])
        texts = {"timer": f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}",
                 "jackpot": f"{figures['jackpot']:g}", "last": self.get("last", "")}  # fmt: skip
        for name, goal in self.rules.goals.items():
            texts[f"goal {name}"] = f"{figures['goals'][name]:g} / {goal.target:g}"
        for name, text in texts.items():
            file = Path(self.rules.game.texts, f"{name}.txt")
            if not file.exists() or file.read_text("utf-8") != text:
                file.write_text(text, "utf-8")

    # OBS.

    async def direct(self) -> None:
        """Do what waits for OBS, over one connection, until it ends."""
        rules, shown = self.rules.obs, ""
        password = rules.password or os.environ.get("OBS_PASSWORD", "")
        self.obs = simpleobsws.WebSocketClient(rules.address, password)
        try:
            await self.obs.connect()
            if not await self.obs.wait_until_identified():
                raise OSError("not connected; is the password right?")
            while self.obs.is_identified():
                if rules.stage and shown != self.stage:
                    shown = self.stage
                    settings = {"url": shown}
                    await self.call(
                        "SetInputSettings", inputName=rules.stage, inputSettings=settings
                    )
                for number, data in self.posted("obs"):
                    await self.act(*data)
                    self.done(number)
                await asyncio.sleep(TURN)
        finally:
            await self.obs.disconnect()

    async def call(self, kind: str, **data: Any) -> dict[str, Any]:
        reply = await self.obs.call(simpleobsws.Request(kind, data or None))
        if not reply.ok():
            log.warning("OBS: %s %s: %s", kind, data, reply.requestStatus.comment)
        return reply.responseData or {}

    async def act(self, kind: str, name: str, seconds: float = 0.0, item: Any = None) -> None:
        """Do one thing. What ends it is posted before, so that a crash leaves nothing behind."""
        scene = (await self.call("GetCurrentProgramScene")).get("currentProgramSceneName")
        match kind:
            case "scene" if scene != name:
                # From the scene of another effect, it leads back to where that one does.
                query = "SELECT data FROM outbox WHERE kind = 'obs' AND due > ?"
                ends = [json.loads(row["data"]) for row in self.rows(query, time.time())]
                homes = {data[1]: data[3] for data in ends if data[0] == "back"}
                self.post("obs", ["back", name, 0.0, homes.get(scene, scene)], DAY, seconds)
                await self.call("SetCurrentProgramScene", sceneName=name)
            case "back" if scene == name:  # else somebody has chosen another one meanwhile
                await self.call("SetCurrentProgramScene", sceneName=item)
            case "source":
                if found := await self.call("GetSceneItemId", sceneName=scene, sourceName=name):
                    item = {"sceneName": scene, **found}
                    self.post("obs", ["hide", name, 0.0, item], DAY, seconds)
                    await self.call("SetSceneItemEnabled", sceneItemEnabled=True, **item)
            case "hide":
                await self.call("SetSceneItemEnabled", sceneItemEnabled=False, **item)
            case "sound":
                rules, action = self.rules.obs, "OBS_WEBSOCKET_MEDIA_INPUT_ACTION_RESTART"
                settings = {"local_file": str(Path(rules.folder, name).resolve())}
                await self.call("SetInputSettings", inputName=rules.sounds, inputSettings=settings)
                await self.call(
                    "TriggerMediaInputAction", inputName=rules.sounds, mediaAction=action
                )


def clean(name: str) -> str:
    """A name as the game shows it: plain text of at most 25 characters."""
    shown = (each for each in unicodedata.normalize("NFC", name) if each.isprintable())
    return " ".join("".join(shown).translate(dict.fromkeys(map(ord, "<>&"))).split())[:25].strip()


def picture(name: str, data: bytes) -> str:
    kind = mimetypes.guess_type(name)[0] or "image/png"
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


async def main(file: Path) -> None:
    rules = read_rules(file)
    os.chdir(file.parent)  # files are named from there
    timeout = aiohttp.ClientTimeout(total=60)
    async with aiohttp.ClientSession(timeout=timeout) as http, asyncio.TaskGroup() as group:
        kit = Kit(rules, http)
        await kit.serve()
        if kit.get("room"):
            print(f"The stage is at {kit.stage}", flush=True)
        tasks = [("The game", kit.drop, 0.0)] * rules.game.falling
        tasks += [("The stage", kit.show, 1.0)]
        if rules.game.texts:
            tasks += [("The text files", kit.write, 1.0)]
        if rules.twitch:
            tasks += [("Twitch", kit.listen, PAUSE), ("The chat", kit.say, PAUSE)]
        if rules.obs:
            tasks += [("OBS", kit.direct, PAUSE)]
        for part, step, pause in tasks:
            group.create_task(forever(part, step, pause))


if __name__ == "__main__":
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S")
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(main(Path(sys.argv[1]).resolve()))
