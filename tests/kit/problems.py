"""Problem details: what a refused request is answered with."""

from typing import Any

import httpx
import msgspec

from plinko.app.web.problems import Problem


def problem(response: httpx.Response, status: int, code: str, *named: str) -> dict[str, Any]:
    """The problem details of a response, which must have this code and name these values."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    value = msgspec.json.decode(response.content, type=Problem)
    assert (value.status, value.code) == (status, code)
    assert value.type.endswith(code)
    assert value.title
    for name in named:
        assert name in value.detail
    found: dict[str, Any] = response.json()
    return found
