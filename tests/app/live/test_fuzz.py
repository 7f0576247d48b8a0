"""Any amount of malformed input causes no failure, no crash and no growth of memory."""

import asyncio
import base64
import os
import urllib.request
from collections import Counter
from pathlib import Path

import httpx
import pytest

from benchmarks.serving.process import Served, can_watch, serving
from tests.app.live import garbled
from tests.kit.serving import constants
from tests.kit.serving import serving as serving_here
from tests.kit.waiting import LIMIT, eventually
from tests.long import tries

MESSAGES = tries(3_000, 100_000)
GROWTH = 8e6
"""Bytes that the server may grow by between the first and the last third of the messages."""

OPTIONS = ("--drop-rate", "1000000", "--max-balls", "20")


async def torment(server: Served, seed: int, count: int) -> Counter[str]:
    """Send at least `count` malformed messages, each batch over a new connection."""
    host, _, port = server.address.removeprefix("http://").partition(":")
    seen: Counter[str] = Counter()
    for batch in garbled.batches(seed):
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write(
            b"GET /ws/rooms/triangle-8 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
            b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
            + base64.b64encode(os.urandom(16))
            + b"\r\n\r\n"
        )
        head = await reader.readuntil(b"\r\n\r\n")
        seen[head.partition(b"\r\n")[0].decode()] += 1
        # uvicorn discards messages that arrive in one piece with a protocol violation. So the last
        # frame, the violation, is sent after the answer to a ping behind the others.
        writer.writelines([*batch[:-1], garbled.framed(1, b'{"type":"ping","t":1}')])
        if await swallow(reader, until=b'"type":"pong"'):
            writer.write(batch[-1])
            writer.write_eof()
            await swallow(reader)
        writer.close()
        seen["messages"] += len(batch)
        if seen["messages"] >= count:
            break
    return seen


async def swallow(reader: asyncio.StreamReader, until: bytes = b"") -> bool:
    """Read until these bytes come; False if the server closes the connection before."""
    last = b""
    try:
        while data := await reader.read(65536):
            last = last[-len(until) :] + data
            if until and until in last:
                return True
    except ConnectionError:
        pass  # the server closed the connection before it had read everything
    return False


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.skipif(not can_watch(), reason="memory is read from /proc")
async def test_malformed_messages_neither_fail_nor_grow_the_server(
    tmp_path: Path,
) -> None:
    with (tmp_path / "log").open("w+") as log, serving(OPTIONS, log=log) as server:
        seen = await torment(server, 1, MESSAGES // 3)
        early = server.resident
        for seed in (2, 3):
            seen += await torment(server, seed, MESSAGES // 3)
        late = server.resident
        assert set(seen) == {"messages", "HTTP/1.1 101 Switching Protocols"}
        with urllib.request.urlopen(f"{server.address}/readyz") as answer:
            assert answer.status == 200
        await eventually(lambda: not server.metrics()["plinko_clients"])
        metrics = server.metrics()
        told = sum(n for name, n in metrics.items() if name.startswith("plinko_errors_total"))
        assert told > MESSAGES / 2, "the others broke the connection, or turned out well"
        assert 'plinko_errors_total{code="server-error"}' not in metrics
        log.seek(0)
        assert log.read().strip() == ""
    assert late - early < GROWTH


# The whole REST interface, from its OpenAPI document.


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_whatever_is_asked_the_answer_is_one_that_is_promised() -> None:
    """Every operation of /openapi.json except endless streams, with valid and invalid values."""
    from tests.app.live.rest_requests import WRONG, ask, operations_of

    failures = []
    with (
        constants(**{"plinko.app.web.routes.rooms.rooms.WAIT_SECONDS": 0.2}),
        serving_here(drop_rate=1e6, max_rooms=1_000_000) as server,
    ):
        found = operations_of(f"{server.url}/openapi.json")
        for operation in found:
            room = httpx.post(
                f"{server.url}/api/v1/rooms", json={"board": "triangle-8"}, timeout=LIMIT
            ).json()
            try:
                ask(operation, room)
            except WRONG as failure:
                failures.append(f"{operation.label}: {failure}")
        assert len(found) > 15
        assert httpx.get(f"{server.url}/readyz", timeout=LIMIT).status_code == 200
        assert 'code="server-error"' not in httpx.get(f"{server.url}/metrics", timeout=LIMIT).text
    assert not failures, "\n\n".join(failures)
