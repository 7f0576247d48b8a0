"""A part that is not installed is answered with 501, and is no failure of the server's."""

import logging

import httpx
import pytest

from app.web.routes.drops import certificates


@pytest.mark.parametrize(
    "path", ["boards/triangle-8/map", "boards/triangle-8/map.png", "drops/triangle-8/1?certified=1"]
)
def test_a_missing_part_is_no_error_in_the_log(
    http: httpx.Client,
    path: str,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(certificates, "_is_installed", lambda: False)
    with caplog.at_level(logging.INFO):
        answer = http.get(f"/api/v1/{path}")
    assert (answer.status_code, answer.json()["code"]) == (501, "not-installed")
    assert [each.getMessage() for each in caplog.records if each.levelno >= logging.WARNING] == []
