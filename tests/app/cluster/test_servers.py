"""To clients three servers act as one, whichever they ask and whichever ends."""

import asyncio
import contextlib
import functools
import hashlib
import re
import signal
from typing import Any

import httpx
import pytest
from click.testing import CliRunner
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from plinko.app.cli import plinko
from plinko.engine import Board, drop
from tests.app.cluster.servers import Servers
from tests.kit.player import Player, playing
from tests.kit.postgres import PostgreSQL
from tests.kit.process import OPERATOR, ServerProcess
from tests.kit.siege import CLIENT_SEED, Heard, prove
from tests.kit.waiting import LIMIT, eventually, until

BOARD = "triangle-8"

pytestmark = pytest.mark.postgresql


def new_room(at: ServerProcess, board: Any = BOARD) -> str:
    """Create a private room at this server."""
    answer = httpx.post(f"{at.url}/api/v1/rooms", json={"board": board}, timeout=LIMIT)
    room: str = answer.raise_for_status().json()["id"]
    return room


def drop_at(one: ServerProcess, room: str, seed: int, *, wait: bool = False) -> dict[str, Any]:
    """Drop a ball through this server; returns its answer."""
    address = f"{one.url}/api/v1/rooms/{room}/drops{'?wait=1' if wait else ''}"
    answer = httpx.post(address, json={"seed": str(seed)}, timeout=LIMIT)
    assert answer.status_code in (200, 202), answer.text
    body: dict[str, Any] = answer.json()
    return body


def move(room: str, to: ServerProcess, ask: ServerProcess) -> httpx.Response:
    return httpx.post(
        f"{ask.url}/api/v1/rooms/{room}/move",
        json={"to": to.name},
        headers={"authorization": f"Bearer {OPERATOR}"},
        timeout=LIMIT,
    )


def same_as_alone(landed: dict[str, Any], seed: int, board: Any = BOARD) -> bool:
    """Whether a ball landed as the engine alone computes it."""
    alone = drop(Board.preset(board) if board == BOARD else Board.from_json(board), seed)
    return (landed["digest"], landed["bin"]) == (alone.digest, alone.bin)


def test_a_room_is_one_room_whichever_server_is_asked(servers: Servers) -> None:
    room = new_room(servers.all[0])
    balls = [drop_at(one, room, 10 + k)["ball"] for k, one in enumerate(servers)]
    assert balls == [0, 1, 2]
    for one in servers:
        assert one.get(f"/api/v1/rooms/{room}").json()["id"] == room
        assert room in {each["id"] for each in one.get("/api/v1/rooms").json()["rooms"]}
        assert one.get(f"/api/v1/rooms/{room}/frame.png").headers["content-type"] == "image/png"
        assert one.get("/api/v1/rooms/nowhere").status_code == 404
    assert servers.holder(room) is servers.all[0]


def test_a_drop_counts_where_its_room_is_and_nowhere_else(servers: Servers) -> None:
    right, wrong, _ = servers.all
    rooms = [new_room(one) for one in (right, wrong)]
    before = {one.name: dropped_at(one) for one in servers}
    allowed = [
        httpx.post(f"{wrong.url}/api/v1/rooms/{room}/drops", json={"seed": "1"}, timeout=LIMIT)
        .raise_for_status()
        .headers["ratelimit-policy"]
        for room in (*rooms, rooms[0])
    ]
    at_right, at_wrong = '"drops";q=2000;w=2', '"drops";q=2002;w=2'
    assert allowed == [at_right, at_wrong, at_right]
    counted = {one.name: dropped_at(one) - before[one.name] for one in servers}
    assert counted == {"plinko1": 2, "plinko2": 1, "plinko3": 0}


def dropped_at(one: ServerProcess) -> float:
    """How many drops this server's metrics count."""
    (line,) = re.findall(r"^plinko_drops_total\S* (\S+)$", one.get("/metrics").text, re.MULTILINE)
    return float(line)


async def test_a_player_at_the_wrong_server_sees_and_does_the_same(
    servers: Servers,
) -> None:
    right, wrong, _ = servers.all
    room = new_room(right)
    async with playing(wrong.socket(room)) as far, playing(right.socket(room)) as near:
        await far.send(type="drop", seed=5, ref="mine")
        accepted = await far.until("accepted")
        assert accepted["ref"] == "mine"
        landed = await far.until("landed")
        assert same_as_alone(landed, 5)
        assert await near.until("landed") == landed
        assert far.binaries, "no picture came"


def test_a_session_is_available_at_every_server_and_is_fair(servers: Servers) -> None:
    first, second, third = servers.all
    room = new_room(first)
    committed = hashlib.sha256(CLIENT_SEED).hexdigest()
    begun = httpx.post(
        f"{second.url}/api/v1/sessions", json={"room": room, "commitment": committed}, timeout=LIMIT
    )
    assert begun.status_code == 201, begun.text
    session, token = begun.json()["session"], begun.json()["token"]
    shown = {"authorization": f"Bearer {token}"}
    assert third.get(f"/api/v1/sessions/{session}").json()["room"] == room
    opening = httpx.post(
        f"{third.url}/api/v1/sessions/{session}/opening",
        json={"seed": CLIENT_SEED.hex()},
        headers=shown,
        timeout=LIMIT,
    )
    assert opening.status_code == 200, opening.text
    told = Heard(room)
    told.tokens[session] = token
    for one in servers:
        staked = httpx.post(
            f"{one.url}/api/v1/rooms/{room}/drops",
            json={"session": session, "stake": 5},
            headers=shown,
            timeout=LIMIT,
        )
        assert staked.status_code == 202, staked.text
        told.receipts.setdefault(session, []).append(staked.json()["receipt"])
    assert servers.holder(room) is first
    until_still(second, room)
    # The session moves with its room, to a server that signs with the same key.
    assert move(room, third, second).status_code == 200
    assert prove(second, told) == len(servers.all)


def test_a_halt_is_heeded_by_all(servers: Servers) -> None:
    first, second, third = servers.all
    room = new_room(first)

    def halt(halted: bool) -> None:
        httpx.post(
            f"{second.url}/api/v1/halts",
            json={"room": room, "halted": halted},
            headers={"authorization": f"Bearer {OPERATOR}"},
            timeout=LIMIT,
        ).raise_for_status()

    halt(True)
    answers = [
        httpx.post(f"{one.url}/api/v1/rooms/{room}/drops", json={"seed": "1"}, timeout=LIMIT)
        for one in servers
    ]
    assert {answer.status_code for answer in answers} == {409}
    until(lambda: third.get("/api/v1/halts").json()["rooms"])
    halt(False)
    assert drop_at(third, room, 1)["ball"] == 0


async def test_a_moved_room_goes_on_from_its_tick_and_viewers_follow(
    servers: Servers,
) -> None:
    first, second, third = servers.all
    room = new_room(first)
    async with playing(first.socket(room)) as player:
        await player.send(type="drop", seed=7)
        await player.until("accepted")
        environment = {"PLINKO_OPERATOR_TOKEN": OPERATOR}
        done = await asyncio.to_thread(
            CliRunner(env=environment).invoke,
            plinko,
            ["rooms", "move", room, second.name, third.url],
        )
        assert done.exit_code == 0, done.output
        assert second.name in done.output
        with contextlib.suppress(ConnectionClosed):
            while True:
                await player.step()
        assert player.socket.close_code == 1012
        seen = int.from_bytes(player.binaries[-1][4:8], "little") if player.binaries else 0
    async with playing(first.socket(room)) as again:
        assert again.hello["tick"] >= seen
        assert same_as_alone(await landing(again, second, room), 7)
    assert await asyncio.to_thread(servers.holder, room) is second


def test_only_operators_move_rooms_and_only_to_servers(servers: Servers) -> None:
    first, second, _ = servers.all
    room = new_room(first)
    asked = httpx.post(
        f"{second.url}/api/v1/rooms/{room}/move", json={"to": second.name}, timeout=LIMIT
    )
    assert asked.status_code == 401
    nobody = move(room, ServerProcess(name="nobody"), second)
    assert nobody.status_code == 422
    assert nobody.json()["field"] == "to"
    assert first.name in nobody.json()["detail"]
    assert move(room, first, second).json() == {"room": room, "server": first.name}
    assert servers.holder(room) is first


async def test_a_ball_of_a_killed_server_lands_where_it_would_have(
    servers: Servers,
) -> None:
    first, second, third = servers.all
    room, unwatched = new_room(first), new_room(first)
    drop_at(first, room, 21)
    drop_at(third, unwatched, 22)
    async with playing(second.socket(room)) as watching:
        first.end(signal.SIGKILL)
        with contextlib.suppress(ConnectionClosed):
            while True:
                await watching.step()
        assert watching.socket.close_code == 1012, "and not a word of failure"
    async with playing(second.socket(room)) as again:
        assert again.hello["room"] == room
    # Also the room that no client asked for came back.
    for name, seed in ((room, 21), (unwatched, 22)):
        until_still(third, name)
        assert same_as_alone(results(second, name)[0], seed)
    assert drop_at(second, unwatched, 23)["ball"] == 1


def until_still(one: ServerProcess, room: str) -> None:
    """Wait until nothing moves in the room."""
    until(lambda: not room_at(one, room)["awake"])


def results(one: ServerProcess, room: str) -> list[dict[str, Any]]:
    """The results of the room's balls, from its log."""
    drops = one.get(f"/api/v1/rooms/{room}/log").json()["drops"]
    return [each["result"] for each in drops]


def room_at(one: ServerProcess, room: str) -> dict[str, Any]:
    found: dict[str, Any] = one.get(f"/api/v1/rooms/{room}").json()
    return found


async def landing(player: Player, one: ServerProcess, room: str) -> dict[str, Any]:
    """The result of the room's only ball, which may have landed before this player's hello."""
    if player.hello["balls"]:
        return await player.until("landed")
    (result,) = await asyncio.to_thread(results, one, room)
    return result


async def test_a_stopped_server_hands_over_all_its_rooms_and_players(servers: Servers) -> None:
    first, second, third = servers.all
    rooms, elsewhere = [new_room(first) for _ in range(4)], new_room(second)
    for number, room in enumerate(rooms):
        drop_at(first, room, 30 + number)
    async with (
        playing(first.socket(rooms[0])) as player,
        playing(first.socket(elsewhere)) as guest,
    ):
        ending = asyncio.create_task(asyncio.to_thread(first.end, signal.SIGTERM))
        for each in (player, guest):
            with contextlib.suppress(ConnectionClosed):
                while True:
                    await each.step()
            assert each.socket.close_code == 1012
        async with playing(second.socket(rooms[0])) as again:
            assert same_as_alone(await landing(again, second, rooms[0]), 30)
        assert await asyncio.to_thread(servers.has, second, elsewhere), "where it was all the time"
        async with playing(third.socket(elsewhere)) as again:
            assert again.hello["room"] == elsewhere
    assert await ending == 0
    for number, room in enumerate(rooms):
        log = third.get(f"/api/v1/rooms/{room}/log").json()
        assert [each["seed"] for each in log["drops"]] == [str(30 + number)]
    ready = [await asyncio.to_thread(one.get, "/readyz") for one in (second, third)]
    assert sum(answer.json()["cluster"]["rooms"] for answer in ready) >= len(rooms)


async def test_without_postgresql_rooms_stay_and_are_taken_over_later(
    servers: Servers, postgresql: PostgreSQL
) -> None:
    first, second, third = servers.all
    staying, waiting = new_room(second), new_room(first)
    drop_at(third, waiting, 40)
    await asyncio.to_thread(postgresql.end, signal.SIGQUIT)
    try:
        first.end(signal.SIGKILL)
        await eventually(lambda: not second.get("/readyz").json()["cluster"]["leases"])
        refused = await asyncio.to_thread(second.get, f"/api/v1/rooms/{waiting}")
        assert refused.status_code == 503
        assert (await asyncio.to_thread(room_at, second, staying))["id"] == staying
    finally:
        await asyncio.to_thread(postgresql.start)
    await eventually(lambda: second.get("/readyz").json()["cluster"]["leases"])
    until(lambda: third.get(f"/api/v1/rooms/{waiting}").status_code == 200)
    until_still(third, waiting)
    assert same_as_alone(results(second, waiting)[0], 40)
    assert servers.holder(staying) is second, "nobody took it from a server that lived"


@pytest.mark.long("a server is frozen until another has its rooms")
async def test_a_server_that_was_frozen_and_comes_back_harms_nothing(servers: Servers) -> None:
    first, second, third = servers.all
    room = new_room(first)
    drop_at(first, room, 50)
    async with connect(first.socket(room), max_queue=None) as held_up:
        await held_up.recv()
        first.send(signal.SIGSTOP)
        try:
            seen = await asyncio.to_thread(room_at, second, room)
            assert seen["id"] == room, "another server goes on with the room"
            after = await asyncio.to_thread(drop_at, second, room, 51)
            assert after["ball"] == 1
        finally:
            first.send(signal.SIGCONT)
        with contextlib.suppress(ConnectionClosed):
            while True:
                await held_up.recv()
        assert held_up.close_code == 1012
    assert (await asyncio.to_thread(drop_at, first, room, 52))["ball"] == 2
    until_still(third, room)
    log = first.get(f"/api/v1/rooms/{room}/log").json()
    assert [each["seed"] for each in log["drops"]] == ["50", "51", "52"]
    for each in log["drops"]:
        assert same_as_alone(each["result"], int(each["seed"]))


def test_each_server_s_metrics_name_it(servers: Servers) -> None:
    def told_by(one: ServerProcess) -> bool:
        found = one.get("/metrics").text
        process = f'{{process="{one.name}"}}'
        members = f"plinko_cluster_members{process} 3.0" in found
        # On a busy machine PostgreSQL may answer late, and count as down for a moment.
        return members and f"plinko_cluster_leases_up{process} 1.0" in found

    for one in servers:
        until(functools.partial(told_by, one))
