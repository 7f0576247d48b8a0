"""The stream kit: turns chat commands, bits, subs, gifts, points and donations into balls.

    python kit.py rules.toml

README.md next to this file says how to set it up.
"""
# pip install -r requirements.txt

import asyncio
import base64
import json
import logging
import math
import mimetypes
import os
import re
import sqlite3
import sys
import unicodedata
import uuid
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import aiohttp
import msgspec
from aiohttp import web
from journal import Event, Journal
from obs import Obs
from rules import Rules, read_rules
from twitch import FAULTS, Twitch

LONGEST = 30.0  # s until a request is repeated
SOON = 2.0  # s for an avatar
TURN = 0.2  # s between two looks at the journal
PATIENCE = 300  # turns that another program waits for its balls
GONE = (401, 403, 404)  # statuses of a room that is not ours any more
FACE = 1 << 12  # bytes: 25 of them fit into a show

log = logging.getLogger("kit")


class Kit(Journal):
    """Drops the journal's balls into its room, and shows timer, goals and jackpot there."""

    def __init__(self, rules: Rules, http: aiohttp.ClientSession) -> None:
        super().__init__(rules)
        self.http = http
        self.opening = asyncio.Lock()
        self.sent: dict[str, Any] = {}  # the show
        self.texts: dict[str, str] = {}
        self.avatar: Callable[[str], Awaitable[str]] | None = None  # of a viewer, by user

    async def request(
        self, method: str, path: str, body: Any, key: str = ""
    ) -> tuple[int, Any, float]:
        """A reply's status, its body, and the seconds until a repeat; status 0: there is none."""
        headers = {"Authorization": f"Bearer {self.get('token')}"}
        if key:
            headers |= {"Idempotency-Secret": self.get("secret"), "Idempotency-Key": key}
        address = f"{self.rules.game.server}/api/v1/rooms{path}"
        try:
            async with self.http.request(method, address, json=body, headers=headers) as reply:
                after = reply.headers.get("Retry-After", "")
                wait = float(after) if after.isdecimal() else 1.0
                found = await reply.json(content_type=None)
                if not isinstance(found, dict):  # a proxy's
                    raise ValueError(f"not from the game: {found}")
                return reply.status, found, min(wait, LONGEST)
        except (*FAULTS, ValueError) as error:
            return 0, {"detail": str(error) or type(error).__name__}, 1.0

    async def open_room(self, old: str | None) -> None:
        """Open a room in place of `old`, which the server no longer has."""
        board: Any = self.rules.game.board
        if board.endswith(".json"):
            board = json.loads(Path(board).read_text("utf-8"))
        async with self.opening:
            while self.get("room") == old:
                status, reply, wait = await self.request("POST", "", {"board": board})
                if status == 201:
                    with self.db:
                        self.put(room=reply["id"], token=reply["token"])
                    print(f"The stage is at {self.stage}", flush=True)
                elif status == 422:
                    sys.exit(f"the game refuses the board: {reply['detail']}")
                else:
                    log.warning("no room yet: %s", reply.get("detail"))
                    await asyncio.sleep(wait)

    async def drop_all(self) -> None:
        """Drop the balls that have not landed, the oldest first, for ever."""
        places = asyncio.Semaphore(self.rules.game.falling)
        last = 0
        async with asyncio.TaskGroup() as group:
            while True:
                waiting = self.rows(
                    "SELECT number, key, event FROM balls WHERE landed IS NULL AND number > ? "
                    "ORDER BY number LIMIT 1", last,
                )  # fmt: skip
                if not waiting:
                    await asyncio.sleep(TURN)
                    continue
                last, key, event = waiting[0]
                await places.acquire()
                row = self.rows("SELECT * FROM events WHERE id = ?", event)[0]
                group.create_task(self.find_face(row))
                falling = group.create_task(self.drop(key, row))
                falling.add_done_callback(lambda _: places.release())
                await asyncio.sleep(self.rules.game.every)

    async def drop(self, key: str, event: sqlite3.Row) -> None:
        """Drop a ball and wait for its landing; with the same key, a repeat is the same ball."""
        body = {"name": clean(event["name"]), "colour": event["colour"]}
        body = {name: value for name, value in body.items() if value}
        while True:
            room = self.get("room")
            status, reply, wait = await self.request("POST", f"/{room}/drops?wait=1", body, key)
            if status == 200 and "landed" in reply:
                self.land(key, event, reply["landed"])
                return
            if status in GONE:
                await self.open_room(room)
            elif status == 422 and body:  # a name that the game does not show
                body = {}
            elif status != 202:
                log.warning("a ball waits: %s", reply.get("detail"))
                await asyncio.sleep(wait)

    async def show_all(self) -> None:
        """Send the room's show whenever it changes, and write the text files, for ever."""
        while True:
            room, show = self.get("room"), self.figures()
            # A running timer counts on at the stage: only its end can change.
            known = {**show, "timer": (self.show["end"], self.show["paused"]), "room": room}
            if room is None:
                await self.open_room(None)
            elif known != self.sent:
                status, reply, _ = await self.request("PUT", f"/{room}/show", show)
                if status == 200:
                    self.sent = known
                elif status in GONE:
                    await self.open_room(room)
                else:
                    log.warning("the stage shows nothing new: %s", reply.get("detail"))
            self.write_texts()
            await asyncio.sleep(1.0)

    def figures(self) -> dict[str, Any]:
        """The show, as the server takes it."""
        rules, show = self.rules, self.show
        looks = {name: getattr(rules.looks, name) for name in ("panel", "ink", "accent", "font")}
        if rules.looks.logo:
            looks["logo"] = picture(rules.looks.logo, Path(rules.looks.logo).read_bytes())
        goals = [
            {"label": name, "value": show["goals"].get(name, 0.0), "target": goal.target}
            for name, goal in rules.goals.items()
        ]
        faces = self.rows(
            "SELECT DISTINCT e.name, f.face FROM balls b JOIN events e ON e.id = b.event "
            "JOIN faces f ON f.user = e.user AND f.face <> '' WHERE b.landed IS NULL "
            "ORDER BY b.number LIMIT 25"
        )
        found = {"goals": goals, "looks": looks, "faces": {clean(n): face for n, face in faces}}
        if rules.timer:
            running = show["paused"] is None
            found["timer"] = {"left": self.left(), "label": rules.timer.label, "running": running}
        if rules.jackpot:
            found["jackpot"] = {"value": show["jackpot"], "label": rules.jackpot.label,
                                "unit": rules.jackpot.unit}  # fmt: skip
        return found

    def write_texts(self) -> None:
        left, show = math.ceil(self.left()), self.show
        texts = {"timer": f"{left // 3600}:{left // 60 % 60:02}:{left % 60:02}",
                 "jackpot": f"{show['jackpot']:g}", "last": self.get("last", "")}  # fmt: skip
        for name, goal in self.rules.goals.items():
            texts[f"goal {name}"] = f"{show['goals'].get(name, 0.0):g} / {goal.target:g}"
        for name, text in texts.items() if self.rules.game.texts else ():
            if self.texts.get(name) != text:
                Path(self.rules.game.texts, f"{name}.txt").write_text(text, "utf-8")
        self.texts = texts

    async def find_face(self, event: sqlite3.Row) -> None:
        """Learn what a viewer's balls look like: an emoji after the command, or the avatar."""
        said = re.fullmatch(r"\S+\s+([^\w\s<>&:]{1,16})", event["text"])
        known = self.rows("SELECT 1 FROM faces WHERE user = ?", event["user"])
        if not self.rules.looks.faces or (known and not said):
            return
        face = said[1] if said else event["face"]
        try:
            async with asyncio.timeout(SOON):
                if not face and self.avatar:
                    face = await self.avatar(event["user"])
                if "://" in face:
                    async with self.http.get(face) as reply:
                        reply.raise_for_status()
                        data = await reply.content.read(FACE + 1)
                    face = picture(reply.url.path, data) if len(data) <= FACE else ""
        except FAULTS as error:
            log.info("no avatar of %s: %s", event["name"], error)
            return
        with self.db:
            self.db.execute("REPLACE INTO faces VALUES (?, ?)", (event["user"], face))

    # The address for other programs.

    async def hear(self, request: web.Request) -> web.Response:
        """An event from Streamer.bot and its like, in the query or as JSON."""
        given: dict[str, Any] = {"id": str(uuid.uuid4()), **request.query}
        try:
            given |= await request.json() if request.can_read_body else {}
            wait = given.pop("wait", "")
            given["user"] = f"bridge:{given.get('user') or given.get('name', '')}"
            event = msgspec.convert(given, Event, strict=False)
            if not math.isfinite(event.amount):
                raise ValueError(f"amount: {event.amount} is not a number")
        except ValueError as error:
            return web.Response(status=422, text=f"{error}\n")
        balls = self.take(event)
        for _ in range(PATIENCE if wait and balls else 0):
            answer = self.rows("SELECT answer FROM events WHERE id = ?", event.id)[0]["answer"]
            if answer:
                return web.Response(text=answer)
            await asyncio.sleep(TURN)
        return web.json_response({"balls": balls}, status=202)

    async def listen(self) -> None:
        application = web.Application()
        path = f"/{self.get('address')}/event"
        application.add_routes([web.get(path, self.hear), web.post(path, self.hear)])
        runner = web.AppRunner(application, access_log=None)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", self.rules.game.port)
        await site.start()
        port = runner.addresses[0][1]
        print(f"Other programs send events to http://127.0.0.1:{port}{path}", flush=True)


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
    async with aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=60)) as http:
        kit = Kit(rules, http)
        await kit.listen()
        if kit.get("room"):
            print(f"The stage is at {kit.stage}", flush=True)
        async with asyncio.TaskGroup() as group:
            group.create_task(kit.drop_all())
            group.create_task(kit.show_all())
            if rules.twitch:
                twitch = Twitch(kit, rules.twitch, http)
                kit.avatar = twitch.avatar
                group.create_task(twitch.run())
            if rules.obs:
                group.create_task(Obs(kit, rules.obs).run())


if __name__ == "__main__":
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S")
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    asyncio.run(main(Path(sys.argv[1]).resolve()))
