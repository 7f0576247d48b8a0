"""Targets of webhooks that hang, refuse or fail as a test decides."""

import asyncio
import base64
import hashlib
import hmac
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from tests.kit.port import free_port
from tests.kit.waiting import eventually

KEY = b"s" * 32
SECRET = "whsec_" + base64.b64encode(KEY).decode()
URL = "http://target.test/hook"


@dataclass
class FakeTarget:
    """A target without a network; `answers` has its next statuses, errors, or "hangs"."""

    answers: list[Any] = field(default_factory=list)
    bodies: list[bytes] = field(default_factory=list)
    heard: list[dict[str, Any]] = field(default_factory=list)  # events it has acknowledged

    async def handle(self, request: httpx.Request) -> httpx.Response:
        body = await request.aread()
        check_signature(dict(request.headers), body)
        self.bodies.append(body)
        answer = self.answers.pop(0) if self.answers else 204
        if isinstance(answer, Exception):
            raise answer
        if answer == "hangs":
            await asyncio.Event().wait()
        if answer < 300:
            self.heard += msgspec.json.decode(body)["events"]
        return httpx.Response(answer)

    @property
    def transport(self) -> httpx.AsyncBaseTransport:
        return httpx.MockTransport(self.handle)

    @property
    def ids(self) -> list[str]:
        return [event["id"] for event in self.heard]


def check_signature(headers: dict[str, str], body: bytes) -> None:
    """Check a message's signature, as a target does."""
    whole = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
    code = hmac.new(KEY, whole, hashlib.sha256).digest()
    assert headers["webhook-signature"] == f"v1,{base64.b64encode(code).decode()}"


@dataclass
class FlakyTarget:
    """A target over HTTP that answers every other request with 500."""

    heard: list[dict[str, Any]] = field(default_factory=list)  # events it has acknowledged
    port: int = field(default_factory=free_port)
    tries: Iterator[int] = field(default_factory=count)

    async def handle(self, request: Request) -> Response:
        body = await request.body()
        check_signature(dict(request.headers), body)
        if next(self.tries) % 2:
            return Response(status_code=500)
        self.heard.extend(msgspec.json.decode(body)["events"])
        return Response(status_code=204)

    def options(self, folder: Path) -> tuple[str, str]:
        """The flags that make a server send webhooks to it."""
        listed = folder / "webhooks.json"
        url = f"http://127.0.0.1:{self.port}/hook"
        listed.write_bytes(msgspec.json.encode([{"url": url, "secret": SECRET}]))
        return "--webhooks", str(listed)

    @asynccontextmanager
    async def served(self) -> AsyncIterator[None]:
        app = Starlette(routes=[Route("/hook", self.handle, methods=["POST"])])
        config = uvicorn.Config(app, port=self.port, log_config=None, lifespan="off")
        server = uvicorn.Server(config)
        serving = asyncio.create_task(server.serve())
        await eventually(lambda: server.started or serving.done())
        try:
            yield
        finally:
            server.should_exit = True
            await serving

    async def has_heard_of(self, balls: int) -> None:
        """Wait for this many drops and their landings, of one room with the seeds 0, 1, …

        First deliveries must be in the order of the drops, and each drop before its landing.
        """
        await eventually(lambda: len({event["id"] for event in self.heard}) == 2 * balls)
        first = list({event["id"]: event for event in self.heard}.values())
        accepted = [event for event in first if event["type"] == "accepted"]
        assert [event["seed"] for event in accepted] == [str(seed) for seed in range(balls)]
        place = {event["id"]: number for number, event in enumerate(first)}
        for event in accepted:
            ball = f"{event['run']}.{event['ball']}"
            assert place[f"{ball}.accepted"] < place[f"{ball}.landed"]
