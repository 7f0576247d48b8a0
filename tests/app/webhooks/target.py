"""A target of webhooks that tests can have hang, refuse or fail."""

import asyncio
import base64
import hashlib
import hmac
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import httpx
import msgspec
import uvicorn
from starlette.applications import Starlette

from tests.waiting import eventually

KEY = b"s" * 32
SECRET = "whsec_" + base64.b64encode(KEY).decode()
URL = "http://target.test/hook"


@dataclass
class FakeTarget:
    """What one target heard; `answers` are its next ones: a status, or what it raises or does."""

    answers: list[Any] = field(default_factory=list)
    bodies: list[bytes] = field(default_factory=list)
    heard: list[dict[str, Any]] = field(default_factory=list)  # what it has said that it has

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
    """As a target does it."""
    whole = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
    code = hmac.new(KEY, whole, hashlib.sha256).digest()
    assert headers["webhook-signature"] == f"v1,{base64.b64encode(code).decode()}"


@asynccontextmanager
async def served(app: Starlette, port: int) -> AsyncIterator[None]:
    """A real target, at this port."""
    server = uvicorn.Server(uvicorn.Config(app, port=port, log_config=None, lifespan="off"))
    serving = asyncio.create_task(server.serve())
    await eventually(lambda: server.started or serving.done())
    try:
        yield
    finally:
        server.should_exit = True
        await serving
