"""The layer in front of the routes: what a request must pass, and what a response has."""

import asyncio
import json
import re
from collections.abc import AsyncIterator
from typing import Any

import httpx
import pytest
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from plinko.app.settings import Settings
from plinko.app.web.edge import front
from plinko.app.web.edge.front import EMBEDDED, MAX_BODY, SECURITY_HEADERS, Front, note
from plinko.app.web.limits import TokenBucket

LONG = "seed " * 1000
OTHER_SITE = "https://other.example"


async def app(scope: Scope, receive: Receive, send: Send) -> None:
    """Answers as the path says."""
    request = Request(scope, receive)
    match scope["path"]:
        case "/long":
            response: Response = PlainTextResponse(LONG, headers={"etag": '"a"'})
        case "/picture":
            response = Response(LONG, media_type="image/png", headers={"etag": '"a"'})
        case "/same":
            response = Response(status_code=304, headers={"etag": '"a"'})
        case "/framed":
            response = PlainTextResponse("", headers=EMBEDDED)
        case "/made":
            link = '</api/v1/rooms?before=2>; rel="next"'
            response = Response(status_code=201, headers={"location": "/new", "link": link})
        case "/limited":
            note(scope, TokenBucket(1.0, 2.0, 0.0).allowance("drops", 0.0))
            response = PlainTextResponse("")
        case "/read":
            response = PlainTextResponse(str(len(await request.body())))
        case "/fails":
            raise ZeroDivisionError
        case "/stopped":
            raise asyncio.CancelledError
        case _:
            told = request.method, request.client, request.url.scheme, "range" in request.headers
            response = PlainTextResponse(repr(told))
    await response(scope, receive, send)


def client(application: ASGIApp = app, **settings: Any) -> httpx.AsyncClient:
    peer = httpx.ASGITransport(Front(application, Settings(**settings)), client=("192.0.2.1", 7))
    plain = {"accept-encoding": "identity"}
    return httpx.AsyncClient(transport=peer, base_url="http://localhost", headers=plain)


async def get(path: str, method: str = "GET", **headers: Any) -> httpx.Response:
    async with client() as http:
        return await http.request(method, path, headers=headers)


# Hosts and origins.


async def test_two_host_lines_are_refused() -> None:
    async with client() as http:
        lines = [(b"host", b"localhost"), (b"host", b"localhost")]
        refused = await http.get("/", headers=lines)
    assert (refused.status_code, refused.json()["code"]) == (400, "not-http")


@pytest.mark.parametrize(
    ("method", "origin", "status"),
    [
        ("POST", OTHER_SITE, 403),
        ("DELETE", "null", 403),
        *(
            ("POST", origin, 403)
            for origin in ("", "garbage", "http://[", "http://]:8/", "://", "http://127.0.0.1:1")
        ),
        ("POST", "http://localhost@evil.example", 403),
        ("POST", "http://localhost", 200),
        ("GET", OTHER_SITE, 200),
    ],
)
async def test_another_site_s_page_may_only_read(method: str, origin: str, status: int) -> None:
    assert (await get("/", method, origin=origin)).status_code == status


async def test_an_allowed_site_may_do_all_and_reads_errors_too() -> None:
    async with client(allowed_origins=(OTHER_SITE,)) as http:
        for path, status in (("/", 200), ("/fails", 500)):
            answer = await http.post(path, headers={"origin": OTHER_SITE})
            assert answer.status_code == status
            assert answer.headers["access-control-allow-origin"] == OTHER_SITE


async def test_a_foreign_handshake_is_refused_with_the_security_headers() -> None:
    sent: list[Message] = []

    async def receive() -> Message:
        return {"type": "websocket.connect"}

    async def send(message: Message) -> None:
        sent.append(message)

    headers = [(b"host", b"localhost"), (b"origin", OTHER_SITE.encode())]
    scope = {"type": "websocket", "path": "/ws", "headers": headers}
    await Front(app, Settings())(scope, receive, send)
    assert (sent[0]["status"], json.loads(sent[1]["body"])["code"]) == (403, "foreign-origin")
    assert set(SECURITY_HEADERS) <= {name.decode() for name, _ in sent[0]["headers"]}


# Proxies.


async def test_only_a_trusted_proxy_says_who_the_client_is() -> None:
    said = {"x-forwarded-for": "203.0.113.9", "x-forwarded-proto": "https"}
    for trusted, told in (
        (("192.0.2.1",), "'203.0.113.9', port=0), 'https'"),
        ((), "'192.0.2.1', port=7), 'http'"),
    ):
        async with client(trusted_proxies=trusted) as http:
            assert told in (await http.get("/", headers=said)).text


# Bodies.


@pytest.mark.parametrize("method", ["POST", "GET"])
async def test_an_announced_body_over_the_limit_is_refused_unread(method: str) -> None:
    refused = await get("/", method, **{"content-length": str(MAX_BODY + 1)})
    assert (refused.status_code, refused.headers["connection"]) == (413, "close")


@pytest.mark.parametrize(("more", "status"), [(0, 200), (1, 413)])
async def test_a_body_in_chunks_is_counted(more: int, status: int) -> None:
    async def chunks() -> AsyncIterator[bytes]:
        for size in (MAX_BODY // 2, MAX_BODY - MAX_BODY // 2, more):
            yield bytes(size)

    async with client() as http:
        assert (await http.post("/read", content=chunks())).status_code == status


# HEAD.


async def test_a_head_has_the_headers_of_a_get_of_the_whole_and_no_body() -> None:
    whole, head = await get("/long"), await get("/long", "HEAD")
    assert head.content == b""
    del whole.headers["x-request-id"], head.headers["x-request-id"]
    assert head.headers == whole.headers
    seen: list[tuple[str, bool]] = []

    async def noting(scope: Scope, receive: Receive, send: Send) -> None:
        seen.append((scope["method"], b"range" in dict(scope["headers"])))
        await Response()(scope, receive, send)

    async with client(noting) as http:
        await http.head("/", headers={"range": "bytes=0-1"})
    assert seen == [("GET", False)]


async def test_a_stream_ends_after_its_head() -> None:
    sent: list[Message] = []

    async def frames(scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"a frame", "more_body": True})
        assert (await receive())["type"] == "http.disconnect"

    async def receive() -> Message:
        raise AssertionError("the client is still there, so this would wait for ever")

    async def send(message: Message) -> None:
        sent.append(message)

    scope = {"type": "http", "method": "HEAD", "path": "/", "headers": []}
    await Front(frames, Settings())(scope, receive, send)
    assert [message.get("body") for message in sent] == [None, b""]


# Responses.


@pytest.mark.parametrize("path", ["/", "/long", "/fails", "/same"])
async def test_every_response_has_an_id_and_the_security_headers(path: str) -> None:
    answer = await get(path)
    assert re.fullmatch("[0-9a-f]{32}", answer.headers["x-request-id"])
    assert {name: answer.headers[name] for name in SECURITY_HEADERS} == SECURITY_HEADERS
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self' 'wasm-unsafe-eval';" in policy
    assert policy.count("unsafe") == 1, "it may compile WebAssembly, and evaluate nothing"
    assert "http" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert (await get(path, **{"x-request-id": "mine"})).headers["x-request-id"] == "mine"
    bad: list[Any] = ["", "not mine", "x" * 65, "ü".encode()]
    for each in bad:
        chosen = (await get(path, **{"x-request-id": each})).headers["x-request-id"]
        assert re.fullmatch("[0-9a-f]{32}", chosen)


async def test_a_page_for_frames_keeps_its_policy_and_a_limit_is_reported() -> None:
    framed = (await get("/framed")).headers
    assert framed["content-security-policy"] == EMBEDDED["content-security-policy"]
    assert "x-frame-options" not in framed
    limited = (await get("/limited")).headers
    assert (limited["ratelimit-policy"], limited["ratelimit"]) == (
        '"drops";q=2;w=2',
        '"drops";r=2;t=0',
    )
    assert "ratelimit" not in (await get("/")).headers


async def test_below_a_path_addresses_begin_with_it_once() -> None:
    async with client(root_path="/games") as http:
        made = (await http.post("/made")).headers
        assert made["location"] == "/games/new"
        assert made["link"].startswith("</games/api/v1/rooms?before=2>")
        forwarded = (await http.post("/made", headers={"plinko-hops": "1"})).headers
        assert forwarded["location"] == "/new"


async def test_a_compressed_response_has_a_weak_tag_and_caches_know() -> None:
    packed, plain = await get("/long", **{"accept-encoding": "gzip"}), await get("/long")
    assert packed.text == plain.text == LONG
    assert packed.headers["content-encoding"] == "gzip"
    assert (packed.headers["etag"], plain.headers["etag"]) == ('W/"a"', '"a"')
    assert packed.headers["vary"] == plain.headers["vary"] == "Accept-Encoding"
    for path in ("/picture", "/"):
        whole = (await get(path, **{"accept-encoding": "gzip"})).headers
        assert "content-encoding" not in whole
        assert "vary" not in whole
        assert "vary" not in (await get(path)).headers
    # 304 has the tag in the form that the client sent.
    for tag in ('"a"', 'W/"a"'):
        assert (await get("/same", **{"if-none-match": tag})).headers["etag"] == tag


# Errors.


async def test_a_failure_is_answered_once_and_a_stop_as_busy() -> None:
    failed, stopped = await get("/fails"), await get("/stopped")
    assert (failed.status_code, failed.json()["code"]) == (500, "server-error")
    assert (stopped.status_code, stopped.json()["code"]) == (503, "busy")


async def test_a_failure_in_the_middle_of_a_response_ends_it() -> None:
    async def breaks(scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        raise ZeroDivisionError

    async with client(breaks) as http:
        with pytest.raises(ZeroDivisionError):
            await http.get("/")


def test_what_is_packed_already_is_not_compressed_again() -> None:
    assert front._is_packed(b"video/mp4")
    assert front._is_packed(b"Image/PNG; name=x")
    assert not front._is_packed(b"application/json")
