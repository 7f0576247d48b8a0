"""Each proxy passes the client's address on; HAProxy sends a room's requests to one server."""

import contextlib
import os
import subprocess
import threading
from collections import Counter
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.app.conftest import QUICK
from tests.deploy.proxies import DEPLOY, NAME, PROXIES, before, program
from tests.kit.player import playing
from tests.kit.serving import serving
from tests.kit.waiting import LIMIT

CONFIGURATION = DEPLOY / "haproxy.cfg"
HAPROXY = program("haproxy")
SERVERS = 3

needs_haproxy = pytest.mark.skipif(HAPROXY is None, reason="no HAProxy: apt-get install haproxy")


class Named(ThreadingHTTPServer):
    """A server that answers with its name and the headers that the proxy sent about the client."""

    daemon_threads = True

    def __init__(self, name: str, answer: "type[Answer] | None" = None) -> None:
        super().__init__(("127.0.0.1", 0), answer or Answer)
        self.name = name

    def __enter__(self) -> "Named":
        threading.Thread(target=self.serve_forever, args=(0.01,)).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
        self.server_close()


class Answer(BaseHTTPRequestHandler):
    """Answers with the server's name and those headers."""

    server: Named

    def do_GET(self) -> None:
        told = (self.headers[each] for each in ("X-Forwarded-For", "plinko-hops"))
        body = " ".join(map(str, (self.server.name, *told))).encode()
        self.send_response(200)
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - its name there
        """Write no log."""


class Once(Answer):
    """Ends a connection at its second request without an answer, like a killed server."""

    protocol_version = "HTTP/1.1"
    asked = 0  # requests on this connection

    def do_GET(self) -> None:
        self.asked += 1
        if self.asked == 1:
            super().do_GET()
        else:
            self.close_connection = True

    def do_POST(self) -> None:
        self.do_GET()


@pytest.fixture
def proxy() -> Iterator[tuple[httpx.Client, list[Named]]]:
    """HAProxy in front of three servers, with a client of it."""
    with proxying() as found:
        yield found


@contextlib.contextmanager
def proxying(relays: int = 0) -> Iterator[tuple[httpx.Client, list[Named]]]:
    with contextlib.ExitStack() as stack:
        names = {f"PLINKO_{k + 1}": f"plinko{k + 1}" for k in range(SERVERS)}
        names |= {f"PLINKO_RELAY_{k + 1}": f"relay{k + 1}" for k in range(relays)}
        servers = [stack.enter_context(Named(name)) for name in names.values()]
        places = {
            variable: f"127.0.0.1:{server.server_port}"
            for variable, server in zip(names, servers, strict=True)
        }
        port = stack.enter_context(before("haproxy", places, DEPLOY))
        yield (
            stack.enter_context(httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0)),
            servers,
        )


def who(client: httpx.Client, path: str, **headers: str) -> str:
    """The name of the server that answers."""
    answer = client.get(path, headers=headers)
    assert answer.status_code == 200, path
    return answer.text.split()[0]


@pytest.fixture(params=PROXIES)
def name(request: pytest.FixtureRequest) -> str:
    """The name of each proxy that has a configuration in `deploy/`."""
    found: str = request.param
    if program(found) is None:
        pytest.skip(f"no {found}: apt-get install {found}")
    return found


@pytest.fixture(scope="module")
def behind() -> Iterator[str]:
    """HOST:PORT of a server behind a proxy."""
    with serving(hosts=(NAME,), trusted_proxies=("127.0.0.1",)) as server:
        yield server.url.removeprefix("http://")


async def test_a_page_plays_over_the_proxy_whatever_its_port(
    name: str, behind: str, tmp_path: Path
) -> None:
    with before(name, {"PLINKO_1": behind}, tmp_path) as port:
        site = f"http://{NAME}:{port}"
        here = {"host": f"{NAME}:{port}", "origin": site}
        address = f"http://127.0.0.1:{port}"
        async with httpx.AsyncClient(base_url=address, headers=here, timeout=LIMIT) as http:
            shown = await http.get("/replay.html?board=triangle-8&seed=1")
            assert f'content="{site}/replay.html?board=triangle-8' in shown.text
            made = await http.post("/api/v1/rooms", json={"board": QUICK})
            assert made.status_code == 201, made.text
        room = f"ws://{NAME}:{port}/ws/rooms/{made.json()['id']}"
        async with playing(room, host="127.0.0.1", port=port, origin=site) as player:
            await player.send(type="drop", seed=1)
            await player.until("landed")


def test_a_proxy_passes_the_client_s_address_and_hides_the_rest(name: str, tmp_path: Path) -> None:
    told = {"x-forwarded-for": "203.0.113.9", "plinko-hops": "3"}
    with (
        Named("plinko1") as server,
        before(name, {"PLINKO_1": f"127.0.0.1:{server.server_port}"}, tmp_path) as port,
        httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as http,
    ):
        http.headers = told | {"host": f"{NAME}:{port}"}
        assert http.get("/").text == "plinko1 127.0.0.1 None"
        assert http.get("/metrics").status_code == 404


@needs_haproxy
def test_its_own_checker_accepts_the_configuration() -> None:
    assert HAPROXY is not None
    # Addresses, because HAProxy warns of server names that it cannot resolve.
    places = {f"PLINKO_{k + 1}": f"127.0.0.1:{8001 + k}" for k in range(SERVERS)}
    done = subprocess.run(
        [HAPROXY, "-c", "-f", str(CONFIGURATION)],
        env=os.environ | places,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "[WARNING]" not in done.stderr + done.stdout


@needs_haproxy
def test_all_that_is_of_one_room_goes_to_one_server(
    proxy: tuple[httpx.Client, list[Named]],
) -> None:
    client, _ = proxy
    rooms = [f"{number:016x}" for number in range(40)]
    found = Counter[str]()
    for room in rooms:
        paths = (
            f"/api/v1/rooms/{room}",
            f"/api/v1/rooms/{room}/log?limit=5",
            f"/api/v1/rooms/{room}/frame.png",
            f"/ws/rooms/{room}?stream=seeds",
            f"/ws/rooms/%{ord(room[0]):x}{room[1:]}",
        )
        (server,) = {who(client, path) for path in paths}
        found[server] += 1
    assert len(found) == SERVERS
    assert min(found.values()) >= 4


@needs_haproxy
def test_viewers_by_seeds_use_relays_where_there_are_some() -> None:
    with proxying(relays=2) as (client, _):
        found = {who(client, "/ws/rooms/main?stream=seeds&watch=true") for _ in range(4)}
        assert found == {"relay1", "relay2"}
        for query in ("", "?stream=seeds", "?watch=true", "?stream=paths&watch=true"):
            path = f"/ws/rooms/main{query}"
            assert who(client, path) == who(client, "/api/v1/rooms/main?stream=seeds&watch=true")
            assert who(client, path).startswith("plinko")


@needs_haproxy
def test_what_is_of_no_room_goes_to_whoever_is_free(
    proxy: tuple[httpx.Client, list[Named]],
) -> None:
    client, _ = proxy
    for path in ("/", "/api/v1/boards", "/api/v1/rooms", "/api/v1/rooms/"):
        assert {who(client, path) for _ in range(2 * SERVERS)} == {
            "plinko1",
            "plinko2",
            "plinko3",
        }, path


@needs_haproxy
def test_a_server_that_has_just_ended_causes_no_error(
    proxy: tuple[httpx.Client, list[Named]],
) -> None:
    client, servers = proxy
    rooms = [f"/ws/rooms/{number:016x}" for number in range(12)]
    before = {room: who(client, room) for room in rooms}
    gone = servers[0]
    gone.shutdown()
    gone.server_close()
    after = {room: who(client, room) for room in rooms}
    assert gone.name in before.values()
    for room in rooms:
        assert after[room] != gone.name
        assert after[room] == before[room] or before[room] == gone.name


@needs_haproxy
def test_a_get_is_tried_again_if_the_line_to_a_server_ends_a_post_not() -> None:
    with Named("once", Once) as server:
        places = {f"PLINKO_{k + 1}": f"127.0.0.1:{server.server_port}" for k in range(SERVERS)}
        with before("haproxy", places, DEPLOY) as port:
            url = f"http://127.0.0.1:{port}/api/v1/rooms/main"
            with httpx.Client(timeout=LIMIT) as http:
                assert [http.get(url).status_code for _ in range(4)] == [200] * 4
            with httpx.Client(timeout=LIMIT) as http:
                assert http.post(url).status_code == 200
                with pytest.raises(httpx.RemoteProtocolError):
                    http.post(url)
