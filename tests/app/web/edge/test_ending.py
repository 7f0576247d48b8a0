"""A client whose request is cut off by shutdown learns of the shutdown, not of an error."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx
import pytest

from plinko.app.persistence.room_log import RoomLogs
from tests.kit.serving import constants, serving
from tests.kit.waiting import until


def test_a_request_that_outlasts_the_grace_of_a_stop_gets_503(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def never(*_: Any, **__: Any) -> None:
        await asyncio.Event().wait()

    monkeypatch.setattr(RoomLogs, "read", never)
    with (
        constants(**{"plinko.app.listening.SHUTDOWN_SECONDS": 1}),
        serving(database_url="sqlite://") as running,
        ThreadPoolExecutor(1) as io,
    ):
        asked = io.submit(httpx.get, f"{running.url}/api/v1/rooms/main/log", timeout=60)
        until(lambda: bool(running.uvicorn.server_state.tasks))
        running.uvicorn.should_exit = True
        answer = asked.result()
    assert (answer.status_code, answer.json()["code"]) == (503, "busy")
    assert answer.json()["detail"] == "the server is stopping"
    assert int(answer.headers["retry-after"]) >= 1
    assert "content-security-policy" in answer.headers
