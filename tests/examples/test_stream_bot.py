"""The bot for a stream's chat goes on for all viewers, whatever a server or a viewer sends."""

import asyncio
import importlib.util
import json
import os
import sys
import threading
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import httpx
import pytest
from websockets.asyncio.server import ServerConnection, serve

from tests.examples.test_examples import EXAMPLES, run
from tests.kit.waiting import LIMIT

_SPEC = importlib.util.spec_from_file_location("stream_bot", EXAMPLES / "stream_bot.py")
assert _SPEC is not None
assert _SPEC.loader is not None
bot: Any = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(bot)

Reply = tuple[int, dict[str, str], bytes]

LANDED = {"landed": {"bin": 3, "score": 1.5, "seed": "7"}}


def landed() -> Reply:
    return 200, {"content-type": "application/json"}, json.dumps(LANDED).encode()


def page(status: int, **headers: str) -> Reply:
    """What a proxy answers in place of the game."""
    head = {"content-type": "text/html"}
    head |= {name.replace("_", "-"): value for name, value in headers.items()}
    return status, head, b"<html>proxy</html>"


class Game:
    """A server that answers each viewer's requests with the given replies, then with a landing."""

    def __init__(self, replies: dict[str, list[Reply]]) -> None:
        self.requests: list[tuple[str, str | None]] = []
        """Name and idempotency key of each request."""
        game = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self) -> None:
                body = json.loads(self.rfile.read(int(self.headers["content-length"])))
                game.requests.append((body["name"], self.headers["idempotency-key"]))
                left = replies.get(body["name"], [])
                status, headers, content = left.pop(0) if left else landed()
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_: object) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.server.serve_forever).start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server.server_port}"

    def stop(self) -> None:
        self.server.shutdown()
        self.server.server_close()


@pytest.fixture
def game() -> Iterator[Callable[[dict[str, list[Reply]]], Game]]:
    games: list[Game] = []

    def begin(replies: dict[str, list[Reply]]) -> Game:
        games.append(Game(replies))
        return games[-1]

    yield begin
    for each in games:
        each.stop()


def said(game: Game, chat: str) -> dict[str, str]:
    """What the bot answers to each viewer of a chat on its standard input."""
    told = run(sys.executable, "stream_bot.py", "--server", game.url, given=chat)
    answers = [line.partition(" ") for line in told.splitlines()]
    return {name.removeprefix("@"): answer for name, _, answer in answers}


GOOD = "bin 3: 1.5x (seed 7)"


def test_a_server_that_is_busy_or_behind_a_broken_proxy_is_asked_again(
    game: Callable[[dict[str, list[Reply]]], Game],
) -> None:
    past = format_datetime(datetime.now(UTC) - timedelta(hours=1), usegmt=True)
    replies: dict[str, list[Reply]] = {
        "ann": [page(502), page(503, retry_after=past)],
        "bob": [page(429, retry_after="0"), page(500, retry_after="0")],
        "cat": [page(504, retry_after="soon"), page(202, retry_after="0")],
        "dan": [page(404)],
        "eve": [(200, {}, b"[]")],
        "fay": [(422, {"content-type": "application/json"}, b'{"detail": "name is not plain"}')],
        "gus": [(200, {"content-type": "application/json"}, b'{"landed": null}')],
        "hal": [(400, {"content-type": "application/json"}, b'"no"')],
    }
    server = game(replies)
    names = [*replies, "zoe"]
    answers = said(server, "".join(f"{name}: !drop\n" for name in names))
    assert {name: answers[name] for name in ("ann", "bob", "cat", "zoe")} == dict.fromkeys(
        ("ann", "bob", "cat", "zoe"), GOOD
    )
    assert answers["dan"] == "not now: the server answered 404"
    assert answers["eve"] == answers["gus"] == "not now: the server answered 200"
    assert answers["fay"] == "not now: name is not plain"
    assert answers["hal"] == "not now: the server answered 400"
    keys = {key for name, key in server.requests if name == "ann"}
    assert len(keys) == 1, "repetitions are one drop"


@pytest.mark.parametrize(
    ("after", "low", "high"),
    [
        (None, 1.0, 1.0),
        ("7", 7.0, 7.0),
        ("0", 0.1, 0.1),
        ("86400", 60.0, 60.0),
        ("9" * 400, 60.0, 60.0),
        ("-3", 1.0, 1.0),
        ("nan", 1.0, 1.0),
        ("soon", 1.0, 1.0),
        ("", 1.0, 1.0),
        ("Wed, 21 Oct 2015 07:28:00 GMT", 0.1, 0.1),
        ("Wed, 21 Oct 2015 07:28:00 -0000", 1.0, 1.0),
        (timedelta(days=1), 60.0, 60.0),
        (timedelta(seconds=50), 0.1, 50.0),
    ],
)
def test_a_pause_is_seconds_or_a_date_within_reason(
    after: str | timedelta | None, low: float, high: float
) -> None:
    if isinstance(after, timedelta):
        after = format_datetime(datetime.now(UTC) + after, usegmt=True)
    headers = {} if after is None else {"retry-after": after}
    assert low <= bot.pause(httpx.Response(503, headers=headers)) <= high


def test_a_viewer_is_told_when_the_server_stays_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bot, "PATIENCE", 0.0)

    async def away() -> str:
        async with httpx.AsyncClient(transport=httpx.MockTransport(refuse)) as client:
            answer: str = await bot.drop(client, "http://game/drops", "ann")
            return answer

    def refuse(request: httpx.Request) -> httpx.Response:
        raise httpx.ConnectError("connection refused", request=request)

    assert asyncio.run(away()) == "not now: connection refused"


@pytest.mark.parametrize(
    "text",
    ["!drop", "!Drop", "!DROP", " !drop ", "!drop \U000e0000", "!drop\U000e0000", "!drop \u034f",
     "!drop\u200b", "\ufeff!drop", "!drop \u2800", "!drop\ufe0f", "!drop\r"],
)  # fmt: skip
def test_a_request_may_be_in_capitals_and_end_in_what_nobody_sees(text: str) -> None:
    assert bot.viewer(f"ann: {text}") == "ann"
    message = f":ann!ann@ann.tmi.twitch.tv PRIVMSG #show :{text}"
    assert bot.viewer(message, (bot.IRC,)) == "ann"
    assert bot.viewer(f"@badges=;color=#00FF00 {message}", (bot.IRC,)) == "ann"


def test_a_name_is_as_long_as_the_game_takes_it() -> None:
    assert bot.viewer(f"!drop {'x' * 30}") == "x" * 24
    assert bot.viewer("!drop  Bob\u202e B. ") == "Bob B."


@pytest.mark.parametrize("text", ["!dropping", "drop", "!drops", "please !drop", "hi", ""])
def test_other_words_are_no_request(text: str) -> None:
    assert bot.viewer(f"ann: {text}") is None
    assert bot.viewer(f":ann!a@b PRIVMSG #show :{text}", (bot.IRC,)) is None


# Whatever a viewer writes is one message of that viewer.
FORGED = [
    "hi\u2028!drop Bob", "hi\u2029!drop Bob", "hi\x0b!drop Bob", "hi\x85!drop Bob",
    "hi\x1e!drop Bob", "hi\r!drop Bob", "Bob: !drop", ":bob!b@b PRIVMSG #show :!drop",
]  # fmt: skip


@pytest.mark.parametrize("text", FORGED)
def test_no_viewer_drops_under_another_s_name(
    game: Callable[[dict[str, list[Reply]]], Game], text: str
) -> None:
    server = game({})
    assert said(server, f"ann: {text}\nzoe: !drop\n") == {"zoe": GOOD}
    assert [name for name, _ in server.requests] == ["zoe"]


def test_a_name_that_looks_like_a_request_is_none() -> None:
    assert bot.viewer("!drop Bob: hello") is None


def chatted(game: Game, *lines: str | bytes, answers: set[str], channel: str = "") -> None:
    """Runs the bot with a chat's messages until it has given these viewers their answers."""

    async def chat(visitor: ServerConnection) -> None:
        for line in lines:
            await visitor.send(line)
        await visitor.wait_closed()

    async def scene() -> None:
        async with serve(chat, "127.0.0.1", 0) as chatting:
            port = next(iter(chatting.sockets)).getsockname()[1]
            running = await asyncio.create_subprocess_exec(
                *(sys.executable, "stream_bot.py", "--server", game.url),
                *("--chat", f"ws://127.0.0.1:{port}"),
                *(("--channel", channel) if channel else ()),
                cwd=EXAMPLES,
                stdout=asyncio.subprocess.PIPE,
                env=os.environ | {"PYTHONIOENCODING": "ascii"},
            )
            assert running.stdout is not None
            left = set(answers)
            async with asyncio.timeout(LIMIT):
                while left:
                    line = (await running.stdout.readline()).decode()
                    left.remove(line.removeprefix("@").partition(" ")[0])
            running.kill()
            await running.wait()

    asyncio.run(scene())


def irc(nick: str, text: str) -> str:
    return f":{nick}!{nick}@{nick}.tmi.twitch.tv PRIVMSG #show :{text}\r\n"


def test_irc_is_read_line_by_line_and_nothing_else_is(
    game: Callable[[dict[str, list[Reply]]], Game],
) -> None:
    server = game({})
    forged = "".join(irc("ann", text) for text in FORGED if "\r" not in text)
    before_zoe = irc("bob", "!Drop \U000e0000") + irc("cat", "!drop please")
    chatted(server, forged, before_zoe.encode(), "!drop Mallory\r\n", "eve: !drop\r\n",
            irc("zoe", "!drop"), answers={"bob", "cat", "zoe"}, channel="#Show")  # fmt: skip
    assert {name for name, _ in server.requests} == {"bob", "cat", "zoe"}


def test_a_message_of_another_chat_is_one_line(
    game: Callable[[dict[str, list[Reply]]], Game],
) -> None:
    server = game({})
    messages = ("ann: hi\n!drop Bob", "Zoë: !drop", b"zoe: !drop")
    chatted(server, *messages, answers={"Zoë", "zoe"})
    assert {name for name, _ in server.requests} == {"Zoë", "zoe"}
