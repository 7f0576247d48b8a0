"""The server's log as lines or as JSON has the same content, and no secrets."""

import asyncio
import json
import logging
import subprocess
import sys
from typing import Any

import pytest

from plinko.app.ops.logs import JsonFormatter, TextFormatter, configure
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT


def record(**extra: Any) -> logging.LogRecord:
    made = logging.makeLogRecord({"name": "plinko", "levelno": 20, "levelname": "INFO"})
    made.msg = "room closed"
    vars(made).update(extra)
    return made


def test_a_line_has_the_event_and_its_particulars() -> None:
    line = json.loads(JsonFormatter().format(record(room="main", balls=3, what=object)))
    assert line["event"] == "room closed"
    assert (line["level"], line["logger"]) == ("info", "plinko")
    assert (line["room"], line["balls"], line["what"]) == ("main", 3, "<class 'object'>")
    assert line["time"].endswith("+00:00")
    assert "error" not in line
    assert TextFormatter().format(record(room="main")).endswith("INFO room closed room=main")


def test_a_json_line_stays_one_line_whatever_it_carries() -> None:
    try:
        raise ValueError("two\nlines")
    except ValueError as error:
        made = record(note="a\nb", exc_info=(type(error), error, error.__traceback__))
    text = JsonFormatter().format(made)
    assert "\n" not in text
    assert "ValueError: two\nlines" in json.loads(text)["error"]


def test_a_failing_request_is_logged_without_its_query(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr("plinko.app.rooms.boards.Boards.find", fail)
    with serving() as server, caplog.at_level(logging.INFO):
        answer = server.get("/api/v1/drops/triangle-8/1?x=0.0625")
    assert answer.status_code == 500
    assert "a bug" not in answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["content-security-policy"]
    assert "ZeroDivisionError" in caplog.text
    ours = [each for each in caplog.records if not each.name.startswith("http")]
    assert "0.0625" not in " ".join(TextFormatter().format(each) for each in ours)
    (line,) = [each for each in ours if each.getMessage() == "request failed"]
    assert vars(line)["path"] == "/api/v1/drops/triangle-8/1"


FAULTS = """
import gc, threading, warnings
from plinko.app.ops.logs import configure
configure("warning", "json")

class Odd:
    def __del__(self): raise ValueError("passed over")

def fail(): raise ValueError("of a thread")

warnings.warn("outdated", stacklevel=1)
Odd()
thread = threading.Thread(target=fail); thread.start(); thread.join()
raise ValueError("of the\\nprocess")
"""


def test_every_line_is_json_whatever_python_has_to_say() -> None:
    done = subprocess.run(
        [sys.executable, "-c", FAULTS], capture_output=True, text=True, timeout=LIMIT, check=False
    )
    lines = [json.loads(line) for line in done.stderr.splitlines()]
    assert done.returncode == 1
    assert [line["level"] for line in lines] == ["warning", "critical", "critical", "critical"]
    assert "outdated" in lines[0]["event"]
    for line, text in zip(lines[1:], ("passed over", "of a thread", "of the"), strict=True):
        assert text in line["error"]


def test_each_request_is_a_line_at_the_level_debug_without_its_query(
    server: Running, caplog: pytest.LogCaptureFixture
) -> None:
    path = "/api/v1/drops/triangle-8/1"
    with caplog.at_level(logging.INFO, "plinko"):
        server.get(f"{path}?x=0.0625")
    with caplog.at_level(logging.DEBUG, "plinko"):
        answer = server.get(f"{path}?x=0.0625")
    (line,) = [vars(each) for each in caplog.records if each.getMessage() == "request"]
    assert (line["client"], line["method"], line["path"]) == ("127.0.0.1", "GET", path)
    assert (line["status"], line["request"]) == (200, answer.headers["x-request-id"])
    assert "0.0625" not in str(line)


def test_events_already_logged_get_no_second_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("", "plinko", "uvicorn", "asyncio"):
        logger = logging.getLogger(name)
        monkeypatch.setattr(logger, "level", logger.level)
        monkeypatch.setattr(logger, "handlers", logger.handlers[:])
    configure("info", "text")
    log = logging.getLogger("uvicorn.error")
    for error in (asyncio.CancelledError("grace exceeded"), ValueError("a fault")):
        try:
            raise error
        except type(error):
            log.exception("Exception in ASGI application")
    log.error("ASGI callable returned without completing response.")
    log.warning("Invalid HTTP request received.")
    log.error("Cancel 3 running task(s), timeout graceful shutdown exceeded")
    lines = capsys.readouterr().err.splitlines()
    assert [line for line in lines if "ERROR" in line] == [lines[0], lines[-1]]
    assert not [line for line in lines if "WARNING" in line]
    assert "Exception in ASGI application" in lines[0]
    assert lines[-2] == "ValueError: a fault"
    assert lines[-1].endswith("Cancel 3 running task(s), timeout graceful shutdown exceeded")
