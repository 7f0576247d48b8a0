"""Private rooms on a real server: tokens, resets, logs and restarts."""

import asyncio
import hashlib
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.errors import SettingError
from plinko.app.live.stored_rooms import UNUSED_SECONDS
from plinko.app.rooms.log import verify_log
from plinko.app.rooms.stakes import payout_of
from plinko.app.web.tokens import secret_of
from plinko.engine import Board, drop
from tests.app.conftest import QUICK, TINY
from tests.app.persistence.conftest import LATER, SQLITE, new_database
from tests.kit.player import playing
from tests.kit.serving import Running, constants, serving
from tests.kit.waiting import eventually, until


@pytest.fixture(scope="module", params=[SQLITE, LATER])
def server(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Running]:
    """A server for tests that use only rooms they create."""
    url = new_database(request, tmp_path_factory.mktemp("rooms"))
    with serving(database_url=url, drop_rate=1000.0, max_rooms=100_000) as running:
        yield running


def client_of(server: Running) -> httpx.Client:
    return server.client("/api/v1")


@pytest.fixture(scope="module")
def http(server: Running) -> Iterator[httpx.Client]:
    with client_of(server) as client:
        yield client


def opened(http: httpx.Client, board: Any = TINY) -> tuple[str, dict[str, str]]:
    """Create a room; returns its id and the headers with its token."""
    reply = http.post("/rooms", json={"board": board})
    assert reply.status_code == 201
    return reply.json()["id"], {"authorization": f"Bearer {reply.json()['token']}"}


def land(http: httpx.Client, room: str, *seeds: int) -> list[dict[str, Any]]:
    replies = [
        http.post(f"/rooms/{room}/drops?wait=1", json={"seed": seed}).json() for seed in seeds
    ]
    return [reply["landed"] for reply in replies]


def verify(tmp_path: Path, log: dict[str, Any]) -> int:
    """Run `plinko verify` on a log; returns the exit code."""
    file = tmp_path / "room.json"
    file.write_text(json.dumps(log))
    return main(["verify", str(file)])


# Tokens.


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [("PATCH", "", {"board": "triangle-8"}), ("POST", "/reset", None), ("DELETE", "", None)],
)
def test_only_the_creator_may_change_a_room(
    http: httpx.Client, method: str, path: str, body: Any
) -> None:
    room, own = opened(http)
    _, others = opened(http)
    where = f"/rooms/{room}{path}"
    missing = http.request(method, where, json=body)
    assert (missing.status_code, missing.json()["code"]) == (401, "token-missing")
    assert missing.headers["www-authenticate"] == "Bearer"
    for wrong in (others["authorization"], "Bearer x", "Bearer é", own["authorization"] + "A"):
        shown = {b"authorization": wrong.encode()}
        refused = http.request(method, where, json=body, headers=shown)
        assert (refused.status_code, refused.json()["code"]) == (403, "not-yours")
        assert wrong.split()[1] not in refused.text or len(wrong) < 10
    public = http.request(method, f"/rooms/main{path}", json=body, headers=own)
    assert (public.status_code, public.json()["code"]) == (403, "not-yours")
    done = http.request(method, where, json=body, headers=own)
    assert done.status_code in (200, 204)


def test_a_token_is_given_once_and_is_nowhere_else(http: httpx.Client) -> None:
    reply = http.post("/rooms", json={"board": TINY})
    token = reply.json()["token"]
    assert reply.headers["cache-control"] == "no-store"
    assert re.fullmatch(r"[\w-]{43}", token)
    room = reply.json()["id"]
    for path in ("/rooms", f"/rooms/{room}", f"/rooms/{room}/log"):
        assert token not in http.get(path).text


def test_a_secret_is_made_once_for_its_owner_and_bad_ones_named(tmp_path: Path) -> None:
    file = tmp_path / "new" / "secret"
    made = secret_of("", file)
    assert len(made) >= 32
    assert file.stat().st_mode & 0o777 == 0o600
    assert secret_of("", file) == made
    assert secret_of("x" * 40, file) == b"x" * 40
    assert secret_of("", None) != secret_of("", None)
    file.write_text("short")
    with pytest.raises(SettingError, match=r"has 5 characters"):
        secret_of("", file)
    with pytest.raises(SettingError, match=r"Is a directory"):
        secret_of("", tmp_path)
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["secret"]


def test_a_killed_process_s_leavings_do_not_block_its_namesake(
    tmp_path: Path,
) -> None:
    """In a container every server has the process id 1."""
    (tmp_path / f"secret.{os.getpid()}").write_text("half of a sec")
    assert len(secret_of("", tmp_path / "secret")) >= 32


# Changing, resetting, closing.


async def test_a_reset_begins_a_new_run_for_all_clients(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http)
    land(http, room, 1)
    async with playing(server.socket(room)) as player:
        assert player.hello["stats"]["drops"] == 1
        await player.send(type="drop", seed=3)
        await player.until("accepted")
        view = http.post(f"/rooms/{room}/reset", headers=own).json()
        assert (view["tick"], view["balls"], view["stats"]["drops"]) == (0, [], 0)
        hello = await player.until("hello")
        assert (hello["tick"], hello["balls"], hello["stats"]["drops"]) == (0, [], 0)
        await player.send(type="drop", seed=4)
        accepted = await player.until("accepted")
        assert accepted["ball"] == 0
        landed = await player.until("landed", ball=0)
    assert landed["digest"] == drop(Board.from_json(TINY), 4).digest
    assert [each["seed"] for each in http.get(f"/rooms/{room}/log").json()["drops"]] == ["4"]


@pytest.mark.parametrize("how", ["POST /reset", "PATCH", "DELETE"])
async def test_a_ball_in_flight_is_paid_whatever_its_owner_does(
    server: Running, http: httpx.Client, how: str
) -> None:
    room, own = opened(http, "triangle-8")
    path = f"/rooms/{room}{how.partition(' ')[2]}"
    body = {"board": "triangle-10"} if how == "PATCH" else None
    async with (
        server.async_client() as waiting,
        playing(server.socket(room)) as player,
    ):
        session, shown = begun(http, room)
        drop_it = {"session": session, "stake": 300}
        address = f"/api/v1/rooms/{room}/drops?wait=1"
        wait = asyncio.create_task(waiting.post(address, json=drop_it, headers=shown))
        accepted = await player.until("accepted")
        http.request(how.partition(" ")[0], path, json=body, headers=own).raise_for_status()
        landed = await player.until("landed", ball=0)
        reply = (await wait).json()
    alone = drop(Board.preset("triangle-8"), int(accepted["seed"]))
    assert (landed["digest"], landed["bin"]) == (alone.digest, alone.bin)
    assert landed["payout"] == payout_of(300, alone.score)
    assert reply["landed"]["digest"] == alone.digest
    http.post(f"/sessions/{session}/end", headers=shown).raise_for_status()
    export = http.get(f"/sessions/{session}/export", headers=shown).raise_for_status().json()
    assert export["drops"][0]["result"]["payout"] == landed["payout"]
    if how == "DELETE":
        log = http.get(f"/rooms/{room}/log").json()
        assert log["drops"][0]["result"]["digest"] == alone.digest
        assert verify_log(log).ok


def begun(http: httpx.Client, room: str) -> tuple[str, dict[str, str]]:
    """Begin and open a session; returns its id and the header with its token."""
    seed = b"\x11" * 32
    commitment = hashlib.sha256(seed).hexdigest()
    form = {"room": room, "commitment": commitment}
    found = http.post("/sessions", json=form).raise_for_status().json()
    shown = {"authorization": f"Bearer {found['token']}"}
    address = f"/sessions/{found['session']}/opening"
    http.post(address, json={"seed": seed.hex()}, headers=shown).raise_for_status()
    return found["session"], shown


def test_a_room_can_be_given_another_board(http: httpx.Client) -> None:
    room, own = opened(http)
    changed = http.patch(f"/rooms/{room}", json={"board": "triangle-8"}, headers=own).json()
    assert changed["board_digest"] == Board.preset("triangle-8").digest
    assert http.get(f"/rooms/{room}").json()["board_name"] == "triangle-8"
    bad = http.patch(f"/rooms/{room}", json={"board": "nope"}, headers=own)
    assert (bad.status_code, bad.json()["code"]) == (404, "unknown-board")


async def test_a_closed_room_sends_everyone_away_for_good(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http)
    async with playing(server.socket(room)) as player:
        await player.send(type="drop", seed=3)
        await player.until("accepted")
        assert http.delete(f"/rooms/{room}", headers=own).status_code == 204
        closed = await player.closing()
    assert closed.rcvd is not None
    assert (closed.rcvd.code, "closed by its creator" in closed.rcvd.reason) == (4004, True)
    assert http.get(f"/rooms/{room}").status_code == 404
    assert http.delete(f"/rooms/{room}", headers=own).status_code == 404
    assert room not in http.get("/rooms").text


async def test_a_room_that_nobody_uses_is_closed(url: str) -> None:
    with (
        constants(**{"plinko.app.live.registry.SEARCH_SECONDS": 0.01}),
        serving(database_url=url) as server,
        client_of(server) as http,
    ):
        room, _ = opened(http)
        assert http.get(f"/rooms/{room}").status_code == 200
        later = server.services.rooms.persistence.now() + UNUSED_SECONDS + 1.0
        server.services.rooms.persistence.runs.now = lambda: later
        await eventually(lambda: not server.services.rooms.is_open(room))
        assert http.get(f"/rooms/{room}").status_code == 404
        assert http.get("/rooms/main").status_code == 200


# Logs.


def test_a_rooms_log_replays_to_the_last_bit(
    server: Running, http: httpx.Client, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room, _ = opened(http)
    land(http, room, 0, 1)
    http.post(f"/rooms/{room}/drops", json={"seed": 6, "aim": 0.0})
    http.post(f"/rooms/{room}/drops", json={"seed": 7, "x": 0.125})
    flying = http.get(f"/rooms/{room}/log").json()
    assert [each["seed"] for each in flying["drops"]] == ["0", "1", "6", "7"]
    assert flying["drops"][2]["aim"] == 0.0
    assert flying["drops"][3]["x"] == 0.125
    assert flying["drops"][3]["result"] is None
    capsys.readouterr()
    assert verify(tmp_path, flying) == 0
    assert capsys.readouterr().out == f"reproduced: 4 drops, {flying['digest']}\n"
    land(http, room, 8)
    landed = http.get(f"/rooms/{room}/log").json()
    assert None not in [each["result"] for each in landed["drops"]]
    assert landed["drops"][0]["result"]["digest"] == drop(Board.from_json(TINY), 0).digest
    assert verify(tmp_path, landed) == 0
    assert verify(tmp_path, landed | {"drops": 7}) == 2
    capsys.readouterr()
    landed["drops"][1]["result"]["bin"] = 7
    assert verify(tmp_path, landed) == 1
    told = capsys.readouterr().out
    assert "drops[1].result.bin differs: the log says 7, the replay gives" in told


# Restarts.


def test_a_restart_finds_rooms_tokens_counts_and_balls_again(url: str, tmp_path: Path) -> None:
    settings: dict[str, Any] = {"database_url": url, "secret": "k" * 40}
    with serving(**settings) as server, client_of(server) as http:
        room, own = opened(http, QUICK)
        asleep, _ = opened(http, "triangle-8")
        first = land(http, room, 1, 2)
        in_flight = http.post("/rooms/triangle-8/drops", json={"seed": 5}).json()
    with serving(**settings) as server:
        assert not any(map(server.services.rooms.is_open, (room, asleep)))
        with client_of(server) as http:

            def rooms() -> dict[str, Any]:
                return {each["id"]: each for each in http.get("/rooms").json()["rooms"]}

            until(lambda: "triangle-8" in rooms())  # soon, without being asked for
            listed = rooms()
            assert {room, asleep, "main", "triangle-8"} <= listed.keys()
            assert (listed[room]["drops"], listed[room]["board_name"]) == (2, "quick")
            assert not server.services.rooms.is_open(room), "a list needs no room in memory"
            flying = http.get("/rooms/triangle-8").json()
            (ball,) = flying["balls"]
            assert (ball["ball"], ball["seed"], ball["tick"]) == (0, "5", in_flight["tick"])
            view = http.get(f"/rooms/{room}").json()
            histogram = [0, 0]
            for landed in first:
                histogram[landed["bin"]] += 1
            assert view["stats"] == {"drops": 2, "histogram": histogram, "unsettled": 0}
            assert land(http, room, 3)[0]["ball"] == 2
            log = http.get(f"/rooms/{room}/log").json()
            assert verify(tmp_path, log) == 0
            assert [each["result"]["digest"] for each in log["drops"][:2]] == [
                landed["digest"] for landed in first
            ]
            until(lambda: not http.get("/rooms/triangle-8").json()["awake"])
            log = http.get("/rooms/triangle-8/log").json()
            assert log["drops"][0]["result"]["digest"] == drop(Board.preset("triangle-8"), 5).digest
            assert verify(tmp_path, log) == 0
            assert http.delete(f"/rooms/{room}", headers=own).status_code == 204
    with serving(**settings) as server, client_of(server) as http:
        assert room not in {each["id"] for each in http.get("/rooms").json()["rooms"]}


def test_rooms_from_before_a_restart_count_for_their_creator(tmp_path: Path) -> None:
    settings: dict[str, Any] = {"database_url": f"sqlite:///{tmp_path / 'plinko.db'}"}
    for statuses in ([201, 201], [201, 429]):
        with serving(**settings, max_rooms=10) as server, client_of(server) as http:
            replies = [http.post("/rooms", json={"board": "triangle-8"}) for _ in range(2)]
            assert [reply.status_code for reply in replies] == statuses
    assert replies[-1].json()["code"] == "room-quota"


# Connections that broke.


async def test_a_reconnected_client_receives_what_it_missed(
    server: Running, http: httpx.Client
) -> None:
    room, own = opened(http)
    async with playing(server.socket(room)) as player:
        await player.send(type="drop", seed=1, ref="one")
        await player.until("accepted")
        hello, heard = player.hello, [*player.events]
        await player.send(type="drop", seed=2, ref="two")
        await eventually(lambda: server.services.rooms.find(room).room.drops == 2)
    since = hello["seq"] + len([e for e in heard if e["type"] in ("accepted", "contact", "landed")])
    await eventually(lambda: not server.services.rooms.find(room).room.awake)
    async with playing(server.socket(room)) as again:
        assert (again.hello["run"], again.hello["seq"] > since) == (hello["run"], True)
        assert again.hello["key"] != hello["key"]
        asking = {"type": "resume", "run": hello["run"], "since": since}
        await again.send(**asking, key=hello["key"])
        answer = await again.until("missed")
        assert (answer["since"], answer["until"]) == (since, again.hello["seq"])
        missed = answer["events"]
        accepted = [(e["ball"], e["ref"]) for e in missed if e["type"] == "accepted"]
        assert accepted == [(1, "two")], "its own note, as before"
        assert {e["ball"] for e in missed if e["type"] == "landed"} == {0, 1}
        await again.send(type="drop", seed=3)
        await again.until("landed")
        await again.send(**asking, key=hello["key"])
        answer = await again.until("missed")
        assert (answer["until"], answer["events"]) == (again.hello["seq"], missed), "heard since"
        await again.send(**asking, key="another")
        assert (await again.until("missed"))["events"][0]["ref"] is None
        await again.send(**asking | {"since": again.hello["seq"]}, key=hello["key"])
        assert (await again.until("missed", since=again.hello["seq"]))["events"] == []
        await again.send(**asking | {"run": "0" * 16}, key=hello["key"])
        assert (await again.until("missed", events=None))["since"] == since
        http.post(f"/rooms/{room}/reset", headers=own)
        await again.until("hello")
        await again.send(**asking, key=hello["key"])
        assert (await again.until("missed", events=None))["since"] == since


def test_kept_events_are_bounded_and_losses_are_reported() -> None:
    from plinko.app.live.broadcast.audience import KEPT, Recent
    from plinko.app.protocol import messages

    def accepted(ball: int) -> messages.Accepted:
        return messages.Accepted(ball=ball, seed="1", x=0.0, explicit_x=False, tick=0)

    recent = Recent("r", 10)
    assert recent.since("r", 9, "", 10) is None, "from before this life"
    for seq in range(11, 11 + KEPT):
        recent.add(seq, accepted(seq))
    assert len(recent.since("r", 10, "", 11 + KEPT) or ()) == KEPT
    recent.add(11 + KEPT, accepted(0))
    assert recent.since("r", 10, "", 11 + KEPT) is None
    assert len(recent.since("r", 11, "", 11 + KEPT) or ()) == KEPT
    told = recent.since("r", 11, "", 20) or []
    heard = [event.ball for event in told if isinstance(event, messages.Accepted)]
    assert heard == [*range(12, 21)], "the later event arrived"
    assert recent.since("other", 11, "", 11 + KEPT) is None
