"""A request is answered here, or forwarded once to the server that has the room."""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import httpx
import pytest
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, Router
from starlette.types import Message, Receive, Scope, Send
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request as WebSocketRequest

from plinko.app.cluster.alive import Alive
from plinko.app.cluster.forward import Forward, Peers
from plinko.app.cluster.membership import Member, Seen
from plinko.app.errors import LeaseLostError
from plinko.app.persistence.lease_book import LeaseBook
from plinko.app.settings import Settings
from plinko.app.web.edge.front import Front
from plinko.app.web.problems import problem_response
from tests.kit.waiting import LIMIT, eventually, turns

THERE = Member("b.1", "b", "http://there:8001")


class Place:
    """A fake server: it returns the given answers, and then echoes requests."""

    def __init__(self, *answers: Response | Exception) -> None:
        self.answers = list(answers)
        self.asked: list[tuple[str, str, httpx.Headers]] = []
        methods = ["GET", "POST"]
        self.app = Router([Route("/{path:path}", self._answer, methods=methods)])

    async def _answer(self, request: Request) -> Response:
        body = (await request.body()).decode()
        self.asked.append((str(request.url.path), body, httpx.Headers(request.headers.raw)))
        answer = self.answers.pop(0) if self.answers else PlainTextResponse(f"had {body}")
        if isinstance(answer, Exception):
            raise answer
        return answer


def moved(holder: str = "") -> LeaseLostError:
    """The error for a request whose room is at another server, or between servers."""
    return LeaseLostError("it is elsewhere", holder=holder)


def broken(_: Scope, error: Exception) -> Response:
    """The connection to a server breaks as its application does."""
    raise error


@asynccontextmanager
async def asking(
    here: Place, there: Place, root_path: str = "", **headers: str
) -> AsyncIterator[httpx.AsyncClient]:
    """A client of the server `here`, which can forward to the server `there`."""
    alive = Alive("", LeaseBook("a.1"), "a")
    alive.look(alive.me, [Seen(THERE, 0.0, connected=True)])
    settings = Settings(hosts=("*",), root_path=root_path)
    peers = Peers(httpx.ASGITransport(app=Front(there.app, settings, broken)))

    async def fetch(room_id: str) -> None:
        raise AssertionError(room_id)

    app = Front(Forward(here.app, alive, peers, fetch), settings)
    transport = httpx.ASGITransport(app=app, client=("192.0.2.7", 1))
    client = httpx.AsyncClient(transport=transport, base_url="http://here", headers=headers)
    async with peers.http, client:
        yield client


async def test_a_request_answered_here_is_not_forwarded() -> None:
    here, there = Place(), Place()
    async with asking(here, there) as client:
        answer = await client.post("/api/v1/rooms/r/drops", content=b"one two")
    assert (answer.status_code, answer.text) == (200, "had one two")
    assert there.asked == []


async def test_a_request_is_forwarded_whole_to_the_server_named() -> None:
    here, there = Place(moved("b.1")), Place()
    async with asking(here, there, authorization="Bearer t", connection="close") as client:
        answer = await client.post("/api/v1/rooms/a%20b/drops?wait=1", content=b"one two")
    assert (answer.status_code, answer.text) == (200, "had one two")
    ((path, body, headers),) = there.asked
    assert (path, body) == ("/api/v1/rooms/a b/drops", "one two")
    assert headers["authorization"] == "Bearer t"
    assert headers["host"] == "here"
    assert headers["x-forwarded-for"] == "192.0.2.7"
    assert headers["plinko-hops"] == "1"
    assert len(here.asked) == 1


async def test_below_a_path_a_new_address_begins_with_that_path_once() -> None:
    made = Response(status_code=201, headers={"location": "/api/v1/rooms/r"})
    here, there = Place(moved("b.1")), Place(made)
    async with asking(here, there, root_path="/games") as client:
        answer = await client.post("/api/v1/rooms")
    assert (answer.status_code, answer.headers["location"]) == (201, "/games/api/v1/rooms/r")


async def test_a_forwarded_request_is_not_forwarded_again() -> None:
    here, there = Place(moved("b.1")), Place()
    async with asking(here, there, **{"plinko-hops": "1"}) as client:
        answer = await client.get("/api/v1/rooms/r")
    assert (answer.status_code, answer.json()["code"]) == (503, "room-moved")
    assert there.asked == []


@pytest.mark.parametrize(
    ("here", "there"),
    [
        ([moved(), moved()], []),  # it was between servers, and arrived here
        ([moved("gone.1")], []),  # its server is unknown; then it arrived here
        (
            [moved("b.1"), moved("b.1")],
            [problem_response(moved("a.1"))],
        ),  # it arrived there only after a while
    ],
)
async def test_a_room_on_its_way_is_waited_for(here: list[Any], there: list[Any]) -> None:
    near, far = Place(*here), Place(*there)
    async with asking(near, far) as client:
        answer = await client.post("/api/v1/rooms/r/drops", content=b"x")
    assert (answer.status_code, answer.text) == (200, "had x")


async def test_a_request_that_may_have_been_done_is_not_repeated() -> None:
    here, there = Place(moved("b.1"), moved("b.1")), Place(httpx.ReadError("it ended"))
    async with asking(here, there) as client:
        answer = await client.post("/api/v1/rooms/r/drops", content=b"x")
    assert (answer.status_code, answer.json()["code"]) == (503, "worker-ended")
    assert len(there.asked) == 1
    here, there = Place(moved("b.1"), moved("b.1")), Place(httpx.ReadError("it ended"))
    async with asking(here, there) as client:
        assert (await client.get("/api/v1/rooms/r")).status_code == 200
    assert len(there.asked) == 2, "reading changes nothing"


@pytest.mark.parametrize("error", [httpx.ConnectError("no"), httpx.ConnectTimeout("no")])
async def test_a_request_that_was_never_sent_is_sent_again(error: Exception) -> None:
    here, there = Place(moved("b.1"), moved("b.1")), Place(error)
    async with asking(here, there) as client:
        answer = await client.post("/api/v1/rooms/r/drops", content=b"x")
    assert (answer.status_code, answer.text) == (200, "had x")


async def test_a_socket_waits_as_long_as_it_takes_for_a_living_server(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The test sets the loop's clock forward while the other server has not answered."""
    loop, jump = asyncio.get_running_loop(), 0.0
    monkeypatch.setattr(loop, "time", lambda: time.monotonic() + jump)
    asked: list[str] = []
    ready, left = asyncio.Event(), asyncio.Event()
    sent: list[Message] = []

    async def take(_: ServerConnection, request: WebSocketRequest) -> None:
        asked.append(request.path)
        await ready.wait()

    async def greet(line: ServerConnection) -> None:
        await line.send("hello")
        await line.wait_closed()

    async def nobody(_scope: Scope, _receive: Receive, _send: Send) -> None:
        raise AssertionError("the room is not here")

    async def fetch(_: str) -> None:
        raise moved("b.1")

    async def receive() -> Message:
        if not sent:
            return {"type": "websocket.connect"}
        await left.wait()
        return {"type": "websocket.disconnect", "code": 1000}

    async def send(message: Message) -> None:
        sent.append(message)

    async with serve(greet, "127.0.0.1", 0, process_request=take, open_timeout=None) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        alive = Alive("", LeaseBook("a.1"), "a")
        there = Member("b.1", "b", f"http://127.0.0.1:{port}")
        alive.look(alive.me, [Seen(there, 0.0, connected=True)])
        peers = Peers()
        scope = {
            "type": "websocket",
            "scheme": "ws",
            "path": "/ws/rooms/r",
            "raw_path": b"/ws/rooms/r",
            "query_string": b"",
            "headers": [(b"host", b"here")],
        }
        talking = asyncio.create_task(Forward(nobody, alive, peers, fetch)(scope, receive, send))
        await eventually(lambda: asked)
        jump = LIMIT / 2
        await turns()
        ready.set()
        await eventually(lambda: any(each.get("text") == "hello" for each in sent))
        left.set()
        await talking
        await peers.http.aclose()
    assert asked == ["/ws/rooms/r"]
