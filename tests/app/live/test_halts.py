"""An operator halts one room or all: drops are refused, balls in flight land and are paid."""

import asyncio
import json
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.errors import HaltedError, LedgerError
from plinko.app.live.orders import HALT, RELEASE
from plinko.app.live.registry import Rooms
from plinko.app.rooms.keys import KeyUse
from plinko.app.rooms.records import EVERY_ROOM, Write
from plinko.app.settings import Settings
from plinko.engine import Board
from tests.app.asking import ask
from tests.app.conftest import TINY
from tests.app.live.sessions.test_fair_sessions import bearer, begun
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.null_ledger import NullLedger
from tests.kit.player import playing
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT, turns, until

TOKEN = "an operator's token of 32 letters"
SETTINGS = Settings(port=0, database_url="sqlite://")


class Refusing(NullLedger):
    """A ledger that refuses writes from the moment the test chooses."""

    def __init__(self) -> None:
        super().__init__()
        self.refuses = False

    async def commit(self, *writes: Write, use: KeyUse | None = None) -> None:
        if self.refuses:
            raise LedgerError("it is full")


@pytest.fixture
def ledger() -> Refusing:
    return Refusing()


@pytest.fixture
def rooms(ledger: Refusing) -> Rooms:
    return rooms_by_hand(Board.from_json(TINY), ledger=ledger, settings=SETTINGS)


async def test_a_halted_table_takes_nothing_and_what_flies_lands(rooms: Rooms) -> None:
    live = rooms.find("main")
    accepted = await ask(live, 7)
    await rooms.orders.give(HALT, "main")
    with pytest.raises(HaltedError, match="the operator of this server has halted room 'main'"):
        await ask(live, 8)
    await ask(rooms.find("triangle-8"), 8)
    while run_pass(rooms.runner):
        pass
    assert (live.room.drops, sum(live.room.histogram), accepted.ball) == (1, 1, 0)
    await rooms.orders.give(RELEASE, "main")
    await ask(live, 8)


async def test_all_tables_halt_at_once_and_a_single_halt_stays(rooms: Rooms) -> None:
    await rooms.orders.give(HALT, "triangle-8")
    await rooms.orders.give(HALT, EVERY_ROOM)
    for name in ("main", "triangle-8", "interacting-triangle-8"):
        with pytest.raises(HaltedError):
            await ask(rooms.find(name), 1)
    await rooms.orders.give(RELEASE, EVERY_ROOM)
    await ask(rooms.find("main"), 1)
    with pytest.raises(HaltedError):
        await ask(rooms.find("triangle-8"), 1)


async def test_a_halt_that_the_ledger_refuses_has_no_effect(rooms: Rooms, ledger: Refusing) -> None:
    ledger.refuses = True
    with pytest.raises(LedgerError):
        await rooms.orders.give(HALT, "main")
    assert not rooms.orders.holds("main")
    ledger.refuses = False
    await rooms.orders.give(HALT, "main")
    ledger.refuses = True
    with pytest.raises(LedgerError):
        await rooms.orders.give(RELEASE, "main")
    assert rooms.orders.holds("main")


async def test_a_cancelled_halt_leaves_no_half_halted_table(rooms: Rooms) -> None:
    asked = asyncio.create_task(rooms.orders.give(HALT, "main"))
    await asyncio.sleep(0)
    asked.cancel()
    await turns()
    assert rooms.orders.holds("main")
    await asyncio.gather(*(rooms.orders.give(each, "main") for each in (RELEASE, HALT, RELEASE)))
    assert not rooms.orders.holds("main")


def change(server: Running, **body: Any) -> httpx.Response:
    return httpx.post(f"{server.url}/api/v1/halts", json=body, headers=bearer(TOKEN), timeout=LIMIT)


def test_a_halt_and_what_was_in_flight_outlive_the_server(tmp_path: Path) -> None:
    board = tmp_path / "tiny.json"
    board.write_text(json.dumps(TINY))
    options: dict[str, Any] = {
        "board": str(board),
        "database_url": f"sqlite:///{tmp_path / 'plinko.db'}",
        "operator_token": TOKEN,
    }
    with serving(**options) as server, server.client() as http:
        session, shown = begun(http)
        body = {"stake": 100, "session": session["session"]}
        assert http.post("/api/v1/rooms/main/drops", json=body, headers=shown).status_code == 202
        assert change(server, room="main", halted=True).json()["rooms"][0]["room"] == "main"
        refused = http.post("/api/v1/rooms/main/drops", json=body, headers=shown)
        assert (refused.status_code, refused.json()["code"]) == (409, "room-halted")
    with serving(**options) as server, server.client() as http:
        refused = http.post("/api/v1/rooms/main/drops", json=body, headers=shown)
        assert refused.json()["code"] == "room-halted"
        assert http.get("/api/v1/halts").json()["rooms"][0]["room"] == "main"
        exported = f"/api/v1/sessions/{session['session']}/export"
        until(lambda: http.get(exported, headers=shown).json()["drops"][0]["result"])
        (drop,) = http.get(exported, headers=shown).json()["drops"]
        assert drop["result"]["payout"] is not None
        assert change(server, room="main", halted=False).json() == {"all_since": None, "rooms": []}
        again = http.post("/api/v1/rooms/main/drops", json=body, headers=shown)
        assert again.status_code == 202
        assert again.json()["receipt"]["receipt"]["drop"] == 1, "no number was spent on a refusal"


async def test_present_and_later_players_learn_of_a_halt() -> None:
    with serving(operator_token=TOKEN) as server:
        async with playing(server.socket("triangle-8")) as player:
            assert change(server, halted=True).status_code == 200
            assert await player.until("halted") == {"type": "halted", "halted": True}
            await player.send(type="drop", ref="mine")
            assert (await player.until("error", ref="mine"))["code"] == "room-halted"
            async with playing(server.socket("triangle-8")) as late:
                await late.until("halted", halted=True)
            assert change(server, halted=False).status_code == 200
            await player.until("halted", halted=False)
            await player.send(type="drop", ref="mine")
            await player.until("accepted", ref="mine")


def test_only_the_operator_may_halt(
    server: Running, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = change(server, halted=True)
    assert (refused.status_code, refused.json()["code"]) == (403, "not-yours")
    assert "PLINKO_OPERATOR_TOKEN" in refused.json()["detail"]
    monkeypatch.delenv("PLINKO_OPERATOR_TOKEN", raising=False)
    with serving(operator_token=TOKEN) as guarded:
        asked = f"{guarded.url}/api/v1/halts"
        assert httpx.post(asked, json={"halted": True}, timeout=LIMIT).status_code == 401
        wrong = httpx.post(asked, json={"halted": True}, headers=bearer("x" * 32), timeout=LIMIT)
        assert wrong.status_code == 403
        assert change(guarded, room="nowhere", halted=True).status_code == 404
        assert httpx.get(asked, timeout=LIMIT).json() == {"all_since": None, "rooms": []}
        # The command.
        assert main(["halt", guarded.url]) == 2
        assert "this needs the token of the operator" in capsys.readouterr().err
        monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", TOKEN)
        assert main(["halt", guarded.url, "--room", "main", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["rooms"][0]["room"] == "main"
        assert main(["halt", guarded.url, "--room", "main", "--release"]) == 0
        assert "not halted" in capsys.readouterr().out
