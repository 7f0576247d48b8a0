"""After a COMMIT whose answer is lost, the server takes nothing back and publishes only facts.

Each kind of write is tried on both databases, with the connection cut or silent. A spy polls
exports and the log meanwhile; at the end every signed head, seed and receipt must be in the ledger.
"""

import contextlib
import hashlib
import itertools
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest
from sqlalchemy import select

from plinko.app.fairness.signing import is_signed
from plinko.app.persistence.ledger.writer import COMMIT_PATIENCE
from plinko.app.persistence.statements import store, tables
from tests.app.conftest import QUICK
from tests.app.persistence.crash.life import look
from tests.app.persistence.ledger.swallowing import (
    LineSwallower,
    SQLiteSwallower,
    Swallower,
    proxied,
)
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT, until
from tests.long import tries

TIMES = tries(1, 200)
SEED = b"\x33" * 32
_POLL = 0.1  # s

_PATIENT = 60.0
"""Seconds: the server notices a cut connection at once; a slow machine must not time out."""

_IMPATIENT = 1.0  # s: the server notices a silent connection only by this time-out


@dataclass
class Spy:
    """Requests the log and exports ten times a second, and keeps the replies."""

    url: str
    sessions: list[tuple[str, dict[str, str]]] = field(default_factory=list)
    """Each session's id and the header with its token, which an export needs."""
    heads: list[dict[str, Any]] = field(default_factory=list)
    exports: list[dict[str, Any]] = field(default_factory=list)
    over: threading.Event = field(default_factory=threading.Event)

    def run(self) -> None:
        with httpx.Client(base_url=f"{self.url}/api/v1", timeout=LIMIT) as http:
            while not self.over.wait(_POLL):
                self._ask(http)
            self._ask(http)  # once at the end, in case no earlier request was answered

    def _ask(self, http: httpx.Client) -> None:
        exports = [(f"/sessions/{each}/export", own) for each, own in self.sessions[-2:]]
        for path, shown in [("/log", None), *exports]:
            reply = http.get(path, headers=shown)
            assert reply.status_code in (200, 503), reply.text
            if reply.status_code == 200:
                (self.heads if path == "/log" else self.exports).append(reply.json())

    def hold(self, url: str) -> None:
        """Check that every kept reply agrees with the ledger."""
        receipts = look(url, lambda c: c.execute(select(tables.receipts)).mappings().all())
        rows = look(url, lambda c: c.execute(select(tables.fair_sessions)).mappings().all())
        roots = {row["leaf"] + 1: row["root"] for row in receipts}
        ended = {row["id"]: row for row in rows if row["end"] is not None}
        drops = {row["id"]: 0 for row in rows}
        for row in receipts:
            drops[row["session"]] += 1
        assert sorted(roots) == list(range(1, len(roots) + 1))
        for found in (*self.heads, *self.exports):
            head = found["head"]
            statement, key = head["statement"], bytes.fromhex(found["key"])
            assert is_signed(statement, bytes.fromhex(head["signature"]), key)
            if statement["size"]:
                assert roots[statement["size"]] == statement["root"], "the log was forked"
        signed = {row["leaf"]: row["signature"] for row in receipts}
        for export in self.exports:
            session = export["session"]["statement"]["session"]
            for each in export["drops"]:
                assert signed[each["index"]] == each["signature"], "a receipt was taken back"
            if export["server_seed"] is not None:
                assert export["end"]["signature"] == ended[session]["end_signature"]
                assert len(export["drops"]) == drops[session], "the seed was revealed too early"


@dataclass
class Attack:
    """A server whose database's answers are swallowed, and requests to it."""

    server: Running
    http: httpx.Client
    swallower: Swallower
    spy: Spy
    cut: bool
    keys: Iterator[int] = field(default_factory=itertools.count)

    def swallowed(self, method: str, path: str, **rest: Any) -> httpx.Response:
        """Send a request, with retries until it is decided; returns the final answer."""
        before = self.swallower.swallowed
        secret = {"idempotency-key": f"key {next(self.keys)}", "idempotency-secret": "s" * 32}
        headers = {**secret, **rest.pop("headers", {})}
        self.swallower.arm(cut=self.cut)
        reply = self.http.request(method, path, headers=headers, **rest)
        codes = [reply.json().get("code")] if reply.content else []
        while reply.status_code == 503:
            assert reply.json()["code"] in ("undecided", "ledger-unavailable"), reply.text
            assert codes[0] == "undecided", "what was sent is never refused"
            until(lambda: self.server.services.ledger.up)
            reply = self.http.request(method, path, headers=headers, **rest)
        assert self.swallower.swallowed == before + 1, "the next commit was the request's own"
        return reply

    def room(self) -> tuple[str, dict[str, str]]:
        made = self.http.post("/rooms", json={"board": QUICK}).raise_for_status().json()
        return made["id"], {"authorization": f"Bearer {made['token']}"}

    def rooms(self) -> set[str]:
        """The ids of all open rooms."""
        found: set[str] = set()
        page: dict[str, Any] = {"next": ""}
        while page["next"] is not None:
            page = self.http.get("/rooms", params={"after": page["next"]}).json()
            found |= {each["id"] for each in page["rooms"]}
        return found

    def session(self, room: str, *, opened: bool = True) -> tuple[str, dict[str, str]]:
        form = {"room": room, "commitment": hashlib.sha256(SEED).hexdigest()}
        made = self.http.post("/sessions", json=form).raise_for_status().json()
        shown = {"authorization": f"Bearer {made['token']}"}
        if opened:
            path = f"/sessions/{made['session']}/opening"
            self.http.post(path, json={"seed": SEED.hex()}, headers=shown).raise_for_status()
        self.spy.sessions.append((made["session"], shown))
        return made["session"], shown

    def still(self, room: str) -> dict[str, Any]:
        """The room when nothing moves in it and the ledger has written all of it."""
        until(lambda: not self.http.get(f"/rooms/{room}").json()["awake"])
        self.http.get(f"/rooms/{room}/log").raise_for_status()  # waits for all earlier writes
        found: dict[str, Any] = self.http.get(f"/rooms/{room}").json()
        return found


def drop(attack: Attack) -> None:
    room, _ = attack.room()
    session, shown = attack.session(room)
    form = {"session": session, "stake": 100}
    first = attack.swallowed("POST", f"/rooms/{room}/drops", json=form, headers=shown)
    assert first.status_code == 202
    assert attack.still(room)["stats"]["drops"] == 1
    second = attack.http.post(f"/rooms/{room}/drops?wait=1", json=form, headers=shown).json()
    assert (first.json()["receipt"]["receipt"]["drop"], second["ball"]) == (0, 1)
    attack.still(room)


def opening(attack: Attack) -> None:
    room, _ = attack.room()
    session, shown = attack.session(room, opened=False)
    path = f"/sessions/{session}/opening"
    reply = attack.swallowed("POST", path, json={"seed": SEED.hex()}, headers=shown)
    assert reply.json()["open"] is True


def end(attack: Attack) -> None:
    room, _ = attack.room()
    session, shown = attack.session(room)
    form = {"session": session, "stake": 100}
    attack.http.post(f"/rooms/{room}/drops?wait=1", json=form, headers=shown).raise_for_status()
    attack.still(room)
    ended = attack.swallowed("POST", f"/sessions/{session}/end", headers=shown).json()
    refused = attack.http.post(f"/rooms/{room}/drops", json=form, headers=shown)
    assert (refused.status_code, refused.json()["code"]) == (409, "session-state")
    reply = attack.http.get(f"/sessions/{session}/export", headers=shown)
    export = reply.raise_for_status().json()
    assert export["server_seed"] == ended["server_seed"]
    assert export["end"]["signature"] == ended["signature"]


def create(attack: Attack) -> None:
    before = attack.rooms()
    made = attack.swallowed("POST", "/rooms", json={"board": QUICK})
    assert attack.rooms() - before == {made.json()["id"]}, "one room was made"
    own = {"authorization": f"Bearer {made.json()['token']}"}
    attack.http.delete(f"/rooms/{made.json()['id']}", headers=own).raise_for_status()


def reset(attack: Attack) -> None:
    room, own = attack.room()
    attack.http.post(f"/rooms/{room}/drops?wait=1").raise_for_status()
    attack.still(room)
    attack.swallowed("POST", f"/rooms/{room}/reset", headers=own)
    assert attack.http.post(f"/rooms/{room}/drops?wait=1").json()["ball"] == 0
    attack.still(room)


def close(attack: Attack) -> None:
    room, own = attack.room()
    attack.swallowed("DELETE", f"/rooms/{room}", headers=own)
    assert attack.http.get(f"/rooms/{room}").status_code == 404


KINDS: list[Callable[[Attack], None]] = [drop, opening, end, create, reset, close]


@pytest.mark.long
@pytest.mark.timeout(4 * 3600)
@pytest.mark.parametrize("cut", [True, False], ids=["cut", "silent"])
def test_a_commit_without_an_answer_is_not_lost_or_undone(
    url: str, cut: bool, tmp_path: Path
) -> None:
    with contextlib.ExitStack() as stack:
        address, proxy = url, None
        if not url.startswith("sqlite"):
            address, proxy = stack.enter_context(proxied(url, tmp_path))
        elif not cut:
            pytest.skip("SQLite has no line that could be silent")
        rates = {"patience": COMMIT_PATIENCE, "drop_rate": 1e6, "max_rooms": 10**6}
        server = stack.enter_context(serving(database_url=address, **rates))
        ledger = server.services.ledger
        ledger.patience = _PATIENT if cut else _IMPATIENT
        if proxy is None:
            swallower: Swallower = SQLiteSwallower(ledger.database)
        else:
            swallower = LineSwallower(ledger.database, proxy)
        http = stack.enter_context(server.client("/api/v1"))
        spy = Spy(server.url)
        polling = threading.Thread(target=spy.run)
        polling.start()
        try:
            attack = Attack(server, http, swallower, spy, cut)
            for kind in KINDS * TIMES:
                kind(attack)
        finally:
            spy.over.set()
            polling.join()
    assert spy.heads
    assert spy.exports, "a session's player is given its exports"
    spy.hold(url)
    assert look(url, store.last_number) > 0
