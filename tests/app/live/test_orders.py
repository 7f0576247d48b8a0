"""The operator announces, bans and closes rooms; each action is in a log that stays."""

import json
import time
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from plinko.app.cli import main
from tests.app.conftest import TINY
from tests.app.live.sessions.test_fair_sessions import bearer
from tests.kit.player import joining, playing
from tests.kit.serving import serving

TOKEN = "an operator's token of 32 letters"


@pytest.fixture(autouse=True)
def token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", TOKEN)


@pytest.fixture
def options(tmp_path: Path) -> dict[str, Any]:
    url = f"sqlite:///{tmp_path / 'plinko.db'}"
    return {"database_url": url, "operator_token": TOKEN, "trusted_proxies": ("127.0.0.1",)}


async def test_players_read_an_announcement_until_it_ends_and_that_the_server_stops(
    options: dict[str, Any],
) -> None:
    with serving(**options) as server:
        async with playing(server.socket("triangle-8")) as player:
            assert main(["announce", "Maintenance at 18:00", server.url]) == 0
            said = {"type": "notice", "text": "Maintenance at 18:00"}
            assert await player.until("notice") == said
            assert "halted" not in player.kinds(), "players read only what has changed"
            server.uvicorn.should_exit = True
            await player.until("notice", leaving=True)
            assert (await player.closed())[0] == 1012
    with serving(**options) as server:
        async with playing(server.socket("triangle-8")) as late:
            assert await late.until("notice") == said
            assert main(["announce", "", server.url]) == 0
            await late.until("notice", text=None)
        async with playing(server.socket("triangle-8")) as later:
            await later.send(type="ping", t=1)
            await later.until("pong")
            assert "notice" not in later.kinds()


async def test_a_banned_client_gets_nothing_until_the_ban_ends(options: dict[str, Any]) -> None:
    banned, other = {"x-forwarded-for": "192.0.2.1"}, {"x-forwarded-for": "192.0.2.2"}
    with serving(**options) as server, server.client() as http:
        async with playing(server.socket(), additional_headers=banned) as player:
            assert main(["players", "ban", "192.0.2.1", server.url]) == 0
            await player.send(type="ping", t=1)
            assert (await player.closed())[0] == 4004, "the page does not come back"
        refused = http.get("/api/v1/boards", headers=banned)
        assert (refused.status_code, refused.json()["code"]) == (403, "banned")
        assert http.get("/api/v1/boards", headers=other).status_code == 200
        with pytest.raises(InvalidStatus):
            await joining(server.socket(), additional_headers=banned)
        assert main(["players", "ban", "192.0.2.1", server.url, "--minutes", "0"]) == 0
        assert http.get("/api/v1/boards", headers=banned).status_code == 200
        # A banned player drops nothing, and a ban ends by itself.
        drops = "/api/v1/rooms/main/drops"
        assert main(["players", "ban", "ann", server.url, "--minutes", "1"]) == 0
        refused = http.post(drops, json={"who": "ann"})
        assert (refused.status_code, refused.json()["code"]) == (403, "banned")
        assert http.post(drops, json={"who": "ben"}).is_success
        server.services.rooms.orders._now = lambda: time.time() + 61.0
        assert http.post(drops, json={"who": "ann"}).is_success


def test_every_action_is_in_the_log(
    options: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    with serving(**options) as server, server.client("/api/v1") as http:
        room = http.post("/rooms", json={"board": TINY}).raise_for_status().json()["id"]
        commands = (
            ["halt", server.url, "--room", "main"],
            ["halt", server.url, "--room", "main", "--release"],
            ["announce", "Hello", server.url],
            ["players", "ban", "ann", server.url],
            ["players", "erase", "ann", server.url],
            ["rooms", "close", room, server.url],
        )
        for command in commands:
            assert main(command) == 0
        assert http.get(f"/rooms/{room}").status_code == 404
        assert main(["rooms", "close", "main", server.url]) == 2, "nobody owns it"
        wrong = http.delete("/rooms/main", headers=bearer("x" * 32))
        assert wrong.status_code == 403
    capsys.readouterr()
    ledger = ["--database-url", options["database_url"]]
    assert main(["ledger", "actions", *ledger, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["actions"]
    assert [(each["action"], each["subject"], each["text"]) for each in found] == [
        ("halt", "main", None),
        ("release", "main", None),
        ("announce", "", "Hello"),
        ("ban", "ann", None),
        ("erase", "", "0 rows"),
        ("close", room, None),
    ]
    assert main(["ledger", "actions", *ledger]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(maxsplit=1)[1].split(" until")[0] for line in lines] == [
        "halt main", "release main", "announce Hello", "ban ann", "erase 0 rows", f"close {room}",
    ]  # fmt: skip


def test_only_the_operator_gives_orders(options: dict[str, Any]) -> None:
    with serving(**options) as server, server.client("/api/v1") as http:
        ban = {"client": "a", "minutes": 1}
        for path, body in (("/announcement", {"text": "x"}), ("/bans", ban)):
            assert http.post(path, json=body).status_code == 401
            assert http.post(path, json=body, headers=bearer("x" * 32)).status_code == 403
        assert http.delete("/players/ann").status_code == 401
        long = {"text": "x" * 501}
        assert http.post("/announcement", json=long, headers=bearer(TOKEN)).status_code == 422
