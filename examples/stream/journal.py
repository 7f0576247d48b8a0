"""The journal: what viewers did, their balls, and what follows from both, in SQLite.

An event has the id that its platform gave it, so a repeat is known. Events with their balls, and
landings with all that they change, are one transaction each. Whatever is killed, and when, no ball
is lost or counted twice.
"""

import hashlib
import json
import secrets
import sqlite3
import time
from decimal import Decimal
from typing import Annotated, Any

import msgspec
from rules import Effects, Figure, Input, Rules

SCHEMA = """
PRAGMA journal_mode = WAL;
PRAGMA synchronous = FULL;
CREATE TABLE IF NOT EXISTS state (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS events (id TEXT PRIMARY KEY, kind TEXT, user TEXT, name TEXT,
    colour TEXT, text TEXT, face TEXT, source TEXT, time REAL, answer TEXT);
CREATE TABLE IF NOT EXISTS balls (number INTEGER PRIMARY KEY, key TEXT UNIQUE, event TEXT,
    bin INTEGER, score REAL, label TEXT, landed REAL);
CREATE INDEX IF NOT EXISTS balls_event ON balls (event);
CREATE INDEX IF NOT EXISTS balls_waiting ON balls (number) WHERE landed IS NULL;
CREATE TABLE IF NOT EXISTS viewers (user TEXT, kind TEXT, rest TEXT, time REAL,
    PRIMARY KEY (user, kind));
CREATE TABLE IF NOT EXISTS faces (user TEXT PRIMARY KEY, face TEXT);
CREATE TABLE IF NOT EXISTS outbox (number INTEGER PRIMARY KEY, kind TEXT, data TEXT, due REAL,
    ends REAL);
"""
MOST = 10_000  # balls of an event
DONE, LATE = 30.0, 600.0  # s after which an action, or an answer in the chat, is of no use any more


class Event(msgspec.Struct):
    """What a viewer did: `kind` is a name in the rules, and `id` is the same in a repeat.

    face: an emoji, or the address of a picture.
    """

    id: str
    kind: str
    name: str = ""
    user: str = ""  # the platform's id of the viewer
    amount: Annotated[float, msgspec.Meta(ge=0, le=1e9)] = 1.0
    text: str = ""
    colour: str = ""
    face: Annotated[str, msgspec.Meta(pattern="^(https?://.*|[^<>&:]{0,16})$")] = ""
    mod: bool = False
    source: str = ""


class Journal:
    def __init__(self, rules: Rules) -> None:
        self.rules = rules
        self.db = sqlite3.connect(rules.game.journal)
        self.db.row_factory = sqlite3.Row
        self.db.executescript(SCHEMA)
        with self.db:
            for name in ("secret", "address"):  # of requests to the game, of ours for programs
                if not self.get(name):
                    self.put(**{name: secrets.token_hex(16)})

    def rows(self, query: str, *values: object) -> list[sqlite3.Row]:
        return self.db.execute(query, values).fetchall()

    def get(self, name: str, default: Any = None) -> Any:
        found = self.rows("SELECT value FROM state WHERE name = ?", name)
        return json.loads(found[0]["value"]) if found else default

    def put(self, **values: Any) -> None:
        for name, value in values.items():
            self.db.execute("REPLACE INTO state VALUES (?, ?)", (name, json.dumps(value)))

    @property
    def stage(self) -> str:
        """The address of the room's stage."""
        options = self.rules.looks.options
        return f"{self.rules.game.server}/stage.html?room={self.get('room')}&{options}".rstrip("&")

    @property
    def show(self) -> dict[str, Any]:
        """`end`: of the timer, Unix time. `paused`: its seconds, while it does not run."""
        timer, jackpot = self.rules.timer or Figure(), self.rules.jackpot or Figure()
        fresh = {"end": 0.0, "paused": timer.start, "jackpot": jackpot.start, "goals": {}}
        found: dict[str, Any] = self.get("show", fresh)
        return found

    def left(self) -> float:
        """Seconds on the timer."""
        end, paused = self.show["end"], self.show["paused"]
        return float(max(0.0, end - time.time() if paused is None else paused))

    def take(self, event: Event) -> int:
        """Write an event with its balls and effects, unless it is known; returns its balls."""
        inputs = self.rules.inputs
        rule = inputs.get(event.kind) or inputs.get(event.kind.partition(":")[0])
        if rule is None or (rule.mods and not event.mod):
            return 0
        row = (event.id, event.kind, event.user, event.name, event.colour, event.text, event.face)
        with self.db:
            added = self.db.execute(
                "INSERT OR IGNORE INTO events VALUES (?, ?, ?, ?, ?, ?, ?, ?, unixepoch(), NULL)",
                (*row, event.source),
            )
            if added.rowcount and (balls := self.worth(event, rule)) is not None:
                self.add(event.id, event.id, balls)
                self.apply(rule, event.id, event.id, name=event.name)
        return len(self.rows("SELECT 1 FROM balls WHERE event = ?", event.id))

    def worth(self, event: Event, rule: Input) -> int | None:
        """The balls for an event; None if the viewer has to wait. What `per` leaves is kept."""
        viewer, now = (event.user, event.kind), time.time()
        known = self.rows("SELECT rest, time FROM viewers WHERE user = ? AND kind = ?", *viewer)
        rest, last = known[0] if known else ("0", 0.0)
        if now - last < rule.every:
            return None
        times, left = max(1, int(event.amount)), Decimal(0)
        if rule.per is not None:
            whole, left = divmod(Decimal(rest) + Decimal(str(event.amount)), Decimal(str(rule.per)))
            times = int(whole)
        self.db.execute("REPLACE INTO viewers VALUES (?, ?, ?, ?)", (*viewer, str(left), now))
        return min(rule.balls * times, MOST)

    def add(self, event: str, key: str, balls: int) -> None:
        """Queue balls of an event. Their keys follow from `key`, so a repeat is the same ball."""
        for n in range(balls):
            row = (hashlib.sha256(f"{key} {n}".encode()).hexdigest(), event)
            self.db.execute("INSERT OR IGNORE INTO balls (key, event) VALUES (?, ?)", row)

    def apply(self, effects: Effects, event: str, key: str, **words: object) -> None:
        """What an event or a landing changes; `key` is its own."""
        show, now = self.show, time.time()
        left = self.left() + effects.timer
        paused = show["paused"] is not None if effects.pause is None else effects.pause
        show["end"], show["paused"] = (0.0, left) if paused else (now + left, None)
        show["jackpot"] += effects.jackpot
        words["jackpot"] = f"{show['jackpot']:g}"
        if effects.pay and self.rules.jackpot:
            show["jackpot"] = self.rules.jackpot.start
        reached = []
        for name, more in effects.goals.items():
            before, goal = show["goals"].get(name, 0.0), self.rules.goals[name]
            show["goals"][name] = before + more
            if before < goal.target <= before + more:
                reached.append(goal.reached)
        self.put(show=show)
        self.add(event, f"{key} again", effects.again)
        if effects.say:
            self.post("say", effects.say.format(**words), keep=LATE)
        for kind in ("scene", "source", "sound"):
            if self.rules.obs and (name := getattr(effects, kind)):
                self.post(kind, [name, effects.seconds])
        for each in reached:
            self.apply(each, event, f"{key} reached", **words)

    def post(self, kind: str, data: Any, due: float = 0.0, keep: float = DONE) -> None:
        """Have something done after this transaction, at least once, unless it is too late."""
        row = (kind, json.dumps(data), due, max(due, time.time()) + keep)
        self.db.execute("INSERT INTO outbox (kind, data, due, ends) VALUES (?, ?, ?, ?)", row)

    def posted(self, *kinds: str) -> list[sqlite3.Row]:
        """What of these kinds is due and not too late, the oldest first."""
        now = time.time()
        rows = self.rows("SELECT * FROM outbox WHERE due <= ? ORDER BY number", now)
        self.done([row for row in rows if row["ends"] < now])
        return [row for row in rows if row["kind"] in kinds and row["ends"] >= now]

    def done(self, rows: list[sqlite3.Row]) -> None:
        with self.db:
            for row in rows:
                self.db.execute("DELETE FROM outbox WHERE number = ?", (row["number"],))

    def land(self, key: str, event: sqlite3.Row, landed: dict[str, Any]) -> None:
        """Write a landing with all that it changes, unless it is known."""
        row = (landed["bin"], landed["score"], landed.get("label"), key)
        words = {"name": event["name"], "bin": landed["bin"], "score": f"{landed['score']:g}x"}
        with self.db:
            written = self.db.execute(
                "UPDATE balls SET bin = ?, score = ?, label = ?, landed = unixepoch() "
                "WHERE key = ? AND landed IS NULL", row,
            )  # fmt: skip
            for number, rule in enumerate(self.rules.landing) if written.rowcount else ():
                if rule.fits(landed):
                    self.apply(rule, event["id"], f"{key} {number}", **words)
            if written.rowcount:
                self.answer(event)

    def answer(self, event: sqlite3.Row) -> None:
        """Write to the viewer where the balls went, once all of them have landed."""
        balls = self.rows("SELECT * FROM balls WHERE event = ?", event["id"])
        if any(ball["landed"] is None for ball in balls):
            return
        best = max(balls, key=lambda ball: ball["score"])
        won = best["label"] or f"{best['score']:g}x"
        text = f"@{event['name']} {won} (bin {best['bin']})"
        if len(balls) > 1:
            total = sum(ball["score"] for ball in balls)
            text = f"@{event['name']} {len(balls)} balls: {total:g}x, the best {won}"
        self.db.execute("UPDATE events SET answer = ? WHERE id = ?", (text, event["id"]))
        self.put(last=text)
        if event["source"] == "twitch":
            self.post("say", text, keep=LATE)
