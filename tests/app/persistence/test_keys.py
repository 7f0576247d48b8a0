"""An idempotency key belongs to its caller and its request, whatever kind of request it is."""

import asyncio
import contextlib
import hashlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.errors import AppError, LeaseLostError
from plinko.app.persistence.statements import store
from plinko.app.rooms.keys import Caller as KeyCaller
from plinko.app.rooms.keys import KeyUse, key_of
from tests.app.conftest import QUICK, TINY
from tests.app.persistence.conftest import POSTGRESQL, SQLITE, new_database
from tests.app.persistence.crash.life import BOARD, living, look
from tests.app.web.test_stories import story
from tests.kit.player import playing
from tests.kit.postgres import PostgreSQL
from tests.kit.serving import Running, serving
from tests.kit.waiting import until

SETTINGS: dict[str, Any] = {
    "secret": "k" * 40,
    "drop_rate": 1000.0,
    "max_rooms": 10_000,
    "operator_token": "o" * 40,
    "trusted_proxies": ("127.0.0.1",),
}
FIRST, SECOND = 0, 1  # two callers
ONE, OTHER = 0, 1  # two requests
SEEDS = (b"\x11" * 32, b"\x22" * 32)

Fact = dict[str, Any]
"""What a reply says of the fact that a request has made, or its error."""


@pytest.fixture(scope="module", params=[SQLITE, POSTGRESQL])
def server(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Running]:
    url = new_database(request, tmp_path_factory.mktemp("keys"))
    with serving(database_url=url, **SETTINGS) as running:
        yield running


def address_of(caller: int) -> dict[str, str]:
    return {"x-forwarded-for": f"192.0.2.{caller + 1}"}


def post(server: Running, path: str, form: Any = None, **headers: str) -> httpx.Response:
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    with server.client("/api/v1") as http:
        return http.post(path, json=form, headers=named)


@dataclass(frozen=True)
class Scene:
    """A room for each caller, whose queues are paused, and an open session of each in the first."""

    rooms: list[str]
    owners: list[dict[str, str]]
    sessions: list[str]
    players: list[dict[str, str]]

    def key(self, key: str) -> str:
        """A key that no other test uses: some belong to an address at the whole server."""
        return f"{self.rooms[0]} {key}"


def bearer(reply: dict[str, Any]) -> dict[str, str]:
    return {"authorization": f"Bearer {reply['token']}"}


def commitment(seed: bytes) -> str:
    return hashlib.sha256(seed).hexdigest()


def scene_at(server: Running) -> Scene:
    scene = Scene([], [], [], [])
    with server.client("/api/v1") as http:
        for seed in SEEDS:
            room = http.post("/rooms", json={"board": TINY}).raise_for_status().json()
            scene.rooms.append(room["id"])
            scene.owners.append(bearer(room))
            path = f"/rooms/{room['id']}/queue"
            http.patch(path, json={"paused": True}, headers=bearer(room)).raise_for_status()
            form = {"room": scene.rooms[0], "commitment": commitment(seed)}
            session = http.post("/sessions", json=form).raise_for_status().json()
            path = f"/sessions/{session['session']}/opening"
            http.post(path, json={"seed": seed.hex()}, headers=bearer(session)).raise_for_status()
            scene.sessions.append(session["session"])
            scene.players.append(bearer(session))
    return scene


def fact_of(reply: httpx.Response, *names: str) -> Fact:
    value = reply.json()
    if reply.is_error:
        return {"status": reply.status_code, "code": value["code"]}
    return {name: value[name] for name in names}


DROP = ("room", "ball", "seed", "x", "tick")


def drop_over_rest(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    path, form = f"/rooms/{scene.rooms[0]}/drops", ({"who": "a"}, {"who": "b"})[request]
    return fact_of(post(server, path, form, idempotency_key=key, **address_of(caller)), *DROP)


def drop_of_a_session(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    """Both callers have one address."""
    form = {"session": scene.sessions[caller], "stake": 100 + request}
    path, shown = f"/rooms/{scene.rooms[0]}/drops", scene.players[caller]
    return fact_of(post(server, path, form, idempotency_key=key, **shown), *DROP, "receipt")


def drop_over_websocket(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    """Each repeat comes over a new connection, with the key of the first one's hello."""

    async def send() -> Fact:
        async with playing(server.socket(scene.rooms[0])) as player:
            hello = f"{scene.rooms[0]} {caller}"
            form = {"who": "ab"[request], "ref": key, "key": hello}
            await player.send(type="drop", **form)
            while True:
                events = await player.step()
                for event in events if isinstance(events, list) else ():
                    if event["type"] == "error":
                        return {"status": 422, "code": event["code"]}
                    if event["type"] == "accepted" and event["ref"] == key:
                        return {name: event[name] for name in DROP if name != "room"}

    return asyncio.run(send())


def room(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    form = {"board": (TINY, "triangle-8")[request]}
    named = {"idempotency_key": scene.key(key), **address_of(caller)}
    return fact_of(post(server, "/rooms", form, **named), "id")


def room_with_a_secret(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    """Both callers have one address."""
    form, secret = {"board": (TINY, "triangle-8")[request]}, f"{caller}" * 32
    named = {"idempotency_key": scene.key(key), "idempotency_secret": secret}
    return fact_of(post(server, "/rooms", form, **named), "id", "token")


def room_of_a_story(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    form = {"story": story(tick=(1, 2)[request], inputs=[])}
    named = {"idempotency_key": scene.key(key), **address_of(caller)}
    return fact_of(post(server, "/rooms", form, **named), "id")


def queue_item(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    """The caller is the owner of the room."""
    path, form = f"/rooms/{scene.rooms[caller]}/queue", {"n": 2, "name": ("Ada", "Ben")[request]}
    reply = post(server, path, form, idempotency_key=key, **scene.owners[caller])
    return fact_of(reply, "room", "waiting", "items")


def session(server: Running, scene: Scene, caller: int, request: int, key: str) -> Fact:
    form = {"room": scene.rooms[0], "commitment": commitment(SEEDS[request])}
    reply = post(server, "/sessions", form, idempotency_key=key, **address_of(caller))
    return fact_of(reply, "session", "statement", "signature")


Way = Callable[[Running, Scene, int, int, str], Fact]

WAYS: list[Way] = [
    drop_over_rest,
    drop_of_a_session,
    drop_over_websocket,
    room,
    room_with_a_secret,
    room_of_a_story,
    queue_item,
    session,
]

REUSED = {"status": 422, "code": "key-reused"}

each_way = pytest.mark.parametrize("way", WAYS, ids=[way.__name__ for way in WAYS])


@each_way
def test_a_key_belongs_to_its_caller_and_its_request(server: Running, way: Way) -> None:
    scene = scene_at(server)
    first = way(server, scene, FIRST, ONE, "k")
    assert "code" not in first
    assert way(server, scene, FIRST, ONE, "k") == first, "the same request, the same fact"
    assert way(server, scene, FIRST, OTHER, "k") == REUSED
    theirs = way(server, scene, SECOND, ONE, "k")
    assert "code" not in theirs
    assert theirs != first, "another caller's key is another key"
    another = way(server, scene, FIRST, ONE, "l")
    assert "code" not in another
    assert another not in (first, theirs), "another key, another fact"
    if way is not queue_item:  # whose reply is the whole queue
        assert way(server, scene, FIRST, ONE, "k") == first


@each_way
def test_concurrent_repeats_are_one_fact(server: Running, way: Way) -> None:
    scene = scene_at(server)
    with ThreadPoolExecutor(8) as clients:
        sent = [clients.submit(way, server, scene, FIRST, ONE, "k") for _ in range(8)]
        first, *others = [each.result() for each in sent]
    assert "code" not in first
    assert others == [first] * 7


def test_a_repeat_after_a_restart_gets_the_same_fact(url: str, tmp_path: Path) -> None:
    settings = {"database_url": url, "data": str(tmp_path), **SETTINGS}
    with serving(**settings) as server:
        scene = scene_at(server)
        first = {way: way(server, scene, FIRST, ONE, way.__name__) for way in WAYS}
    with serving(**settings) as server:
        for way in WAYS:
            assert way(server, scene, FIRST, ONE, way.__name__) == first[way]
            assert way(server, scene, FIRST, OTHER, way.__name__) == REUSED
            assert "code" not in way(server, scene, SECOND, ONE, way.__name__)


# Tokens.


@pytest.mark.parametrize(
    ("path", "form"),
    [
        ("/rooms", {"board": TINY}),
        ("/rooms", {"story": story(tick=1, inputs=[])}),
        ("/sessions", {"room": "main", "commitment": commitment(SEEDS[0])}),
    ],
)
def test_a_token_is_given_again_only_with_the_secret_of_the_first_request(
    server: Running, path: str, form: Any
) -> None:
    key = scene_at(server).key("k")
    token = post(server, path, form, idempotency_key=key).json()["token"]
    assert isinstance(token, str)
    again = post(server, path, form, idempotency_key=key)
    assert (again.status_code, again.json()["token"]) == (201, None)
    assert again.headers["cache-control"] == "no-store"
    named = {"idempotency_key": key, "idempotency_secret": "s" * 32}
    mine = post(server, path, form, **named).json()["token"]
    assert mine not in (None, token), "a caller with a secret is another caller"
    assert post(server, path, form, **named).json()["token"] == mine
    short = post(server, path, form, idempotency_key=key, idempotency_secret="s" * 31)
    assert (short.status_code, short.json()["field"]) == (422, "Idempotency-Secret")


def test_a_neighbour_who_guesses_a_key_gets_no_token_and_closes_nothing(server: Running) -> None:
    """In release 1.0.0, 44 guesses from the same address gave the owner's token."""
    form = {"board": "triangle-8", "mode": "independent"}
    victims = [
        post(server, "/rooms", form, idempotency_key="room-7").json(),
        post(server, "/rooms", form, idempotency_key="room-17", idempotency_secret="v" * 32).json(),
    ]
    found = []
    with server.client("/api/v1") as http:
        for number in range(44):
            for more in ({}, {"idempotency-secret": "w" * 32}):
                headers = {"idempotency-key": f"room-{number}", **more}
                found.append(http.post("/rooms", json=form, headers=headers).json())
        assert victims[0]["id"] in {each["id"] for each in found}, "a public list has it too"
        assert victims[1]["id"] not in {each["id"] for each in found}
        tokens = {each["token"] for each in found}
        for victim in victims:
            assert victim["token"] not in tokens
            for token in (None, found[-1]["token"]):
                shown = {"authorization": f"Bearer {token}"}
                assert http.delete(f"/rooms/{victim['id']}", headers=shown).status_code == 403
            assert http.delete(f"/rooms/{victim['id']}", headers=bearer(victim)).status_code == 204


# What was done stays done.


def test_a_drop_that_was_taken_is_told_again_whatever_has_happened_since(server: Running) -> None:
    """Its session is over, or its room was reset, changed or halted."""
    scene = scene_at(server)
    plain = drop_over_rest(server, scene, FIRST, ONE, "k")
    staked = drop_of_a_session(server, scene, FIRST, ONE, "k")
    end, reset = f"/sessions/{scene.sessions[FIRST]}/end", f"/rooms/{scene.rooms[0]}/reset"

    def told() -> None:
        assert drop_over_rest(server, scene, FIRST, ONE, "k") == plain
        assert drop_of_a_session(server, scene, FIRST, ONE, "k") == staked
        assert drop_of_a_session(server, scene, FIRST, OTHER, "k") == REUSED

    assert post(server, end, **scene.players[FIRST]).status_code == 200
    told()
    ended = drop_of_a_session(server, scene, FIRST, ONE, "new")
    assert ended == {"status": 409, "code": "session-state"}
    assert post(server, reset, **scene.owners[0]).status_code == 200
    told()
    form = {"board": "triangle-8"}
    with server.client("/api/v1") as http:
        changed = http.patch(f"/rooms/{scene.rooms[0]}", json=form, headers=scene.owners[0])
    assert changed.status_code == 200
    told()
    view = post(server, reset, **scene.owners[0]).json()
    assert view["stats"]["drops"] == len(view["balls"]) == 0, "nothing was dropped a second time"
    path = f"/rooms/{scene.rooms[0]}/drops?wait=1"
    landed = post(server, path, {"who": "a"}, idempotency_key="k", **address_of(FIRST))
    assert (landed.status_code, landed.json()["landed"]["ball"]) == (200, plain["ball"])
    halt = {"room": scene.rooms[0], "halted": True}
    post(server, "/halts", halt, authorization=f"Bearer {'o' * 40}").raise_for_status()
    told()
    halted = drop_over_rest(server, scene, FIRST, ONE, "new")
    assert halted == {"status": 409, "code": "room-halted"}


def test_a_reset_and_a_new_board_happen_once(server: Running) -> None:
    scene = scene_at(server)
    path, own = f"/rooms/{scene.rooms[0]}", scene.owners[0]

    def drops() -> int:
        drop_over_rest(server, scene, FIRST, ONE, f"k{len(balls)}")
        with server.client("/api/v1") as http:
            log: list[Any] = http.get(f"{path}/log").json()["drops"]
        return len(log)

    balls: list[int] = []
    for key in ("one", "one", "two", "one"):
        assert post(server, f"{path}/reset", idempotency_key=key, **own).status_code == 200
        balls.append(drops())
    assert balls == [1, 2, 1, 2]
    with server.client("/api/v1") as http:
        asked = [
            http.patch(path, json={"board": board}, headers={"idempotency-key": "one", **own})
            for board in ("triangle-8", "triangle-8", "galton")
        ]
    assert [each.status_code for each in asked] == [200, 200, 422]
    assert asked[2].json()["code"] == "key-reused"


def test_a_closed_room_is_not_opened_again_by_its_key(server: Running) -> None:
    scene = scene_at(server)
    reply = post(server, "/rooms", {"board": TINY}, idempotency_key="closed").json()
    with server.client("/api/v1") as http:
        http.delete(f"/rooms/{reply['id']}", headers=bearer(reply)).raise_for_status()
    again = post(server, "/rooms", {"board": TINY}, idempotency_key="closed")
    assert (again.status_code, again.json()["code"]) == (404, "room-closed")
    assert "use a new key" in again.json()["detail"]
    assert "code" not in room(server, scene, FIRST, ONE, "not closed")


def test_a_queued_item_that_has_been_dropped_is_not_queued_again(url: str) -> None:
    form = {"n": 2, "every": 0.02, "name": "Ada"}
    with serving(database_url=url, **SETTINGS) as server:
        opened = post(server, "/rooms", {"board": QUICK}).json()
        path, own = f"/rooms/{opened['id']}", bearer(opened)
        post(server, f"{path}/queue", form, idempotency_key="gift", **own).raise_for_status()
        live = server.services.rooms.find(opened["id"])
        until(lambda: not live.queue.state.items)
    with serving(database_url=url, **SETTINGS) as server, server.client("/api/v1") as http:
        for expected in (2, 0):  # drops: also a reset does not bring it back
            again = post(server, f"{path}/queue", form, idempotency_key="gift", **own)
            assert (again.status_code, again.json()["waiting"]) == (202, 0)
            assert len(http.get(f"{path}/log").json()["drops"]) == expected
            post(server, f"{path}/reset", **own).raise_for_status()


# Servers that share a ledger.


async def test_two_servers_open_one_room_for_one_key(postgresql: PostgreSQL) -> None:
    address = postgresql.new_database()

    def use() -> KeyUse:
        return KeyUse(key_of("open", "", KeyCaller("address a"), "k", None))

    async with living(address, holder="a") as a, living(address, holder="b") as b:
        opening = [life.rooms.create(BOARD, use=use()) for life in (a, b, a, b)]
        outcomes = await asyncio.gather(*opening, return_exceptions=True)
        rooms = {outcome.id for outcome in outcomes if not isinstance(outcome, BaseException)}
        assert len(rooms) == 1
        for outcome in outcomes:
            if isinstance(outcome, BaseException):  # the request is forwarded to the room's server
                assert isinstance(outcome, LeaseLostError)
                assert outcome.holder
        for life in (a, b):
            with contextlib.suppress(AppError):
                found = await life.rooms.opened_by(use())
                assert found is not None
                assert {found.id} == rooms
            await life.leave()
    assert look(address, store.count_owned) == 1
