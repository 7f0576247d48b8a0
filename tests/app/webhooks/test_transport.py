"""A target that sends too much, or nothing that it should, costs the server little."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import cast

import pytest

from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.webhooks.sender import Webhooks
from plinko.app.webhooks.targets import Target
from plinko.app.webhooks.transport import MOST_READ
from tests.app.webhooks.target import SECRET

CONTINUE = b"HTTP/1.1 100 Continue\r\n\r\n"
OK = b"HTTP/1.1 204 No Content\r\n\r\n"
REDIRECT = b"HTTP/1.1 302 Found\r\nlocation: /\r\ncontent-length: 0\r\n\r\n"


@asynccontextmanager
async def target(said: Callable[[], bytes], *, again: bool) -> AsyncIterator[str]:
    """A target that sends `said()` once it has a request, or again and again."""

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        try:
            writer.write(said())
            while again:
                await writer.drain()
                writer.write(said())
        except OSError:
            pass  # the server has hung up
        finally:
            writer.close()

    async with await asyncio.start_server(answer, "127.0.0.1", 0) as server:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/hook"


async def fault(url: str) -> str | None:
    """What a server says of one request to this target; None if it was accepted."""
    hooks = Webhooks([Target(url, SECRET)], cast(Ledger, None), lambda: True)
    (sender,) = hooks._senders
    async with hooks._http:
        return await sender._try("1-1", b"{}")


@pytest.mark.parametrize("flood", [CONTINUE, b"HTTP/1.1 200 OK\r\n" + b"x: y\r\n" * 9000], ids=len)
async def test_a_target_that_never_ends_its_head_is_given_up_soon(flood: bytes) -> None:
    async with target(lambda: flood, again=True) as url:
        assert await fault(url) == f"more than {MOST_READ} bytes before the reply's head ends"


async def test_a_target_may_say_that_it_goes_on_before_it_accepts() -> None:
    async with target(lambda: 3 * CONTINUE + OK, again=False) as url:
        assert await fault(url) is None


async def test_a_body_without_end_is_not_read() -> None:
    head = b"HTTP/1.1 200 OK\r\ntransfer-encoding: chunked\r\n\r\n"
    async with target(lambda: head + b"5\r\nxxxxx\r\n" * 9000, again=True) as url:
        assert await fault(url) is None


async def test_a_redirect_is_not_followed() -> None:
    async with target(lambda: REDIRECT, again=False) as url:
        assert await fault(url) == "it answered 302"


async def test_a_target_that_is_not_there_is_named() -> None:
    async with target(lambda: OK, again=False) as url:
        gone = url
    assert "connection" in str(await fault(gone)).lower()
