"""How a server starts: a database that is not there yet, wrong settings, a service manager."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.persistence.ledger.database import Database
from plinko.engine import __version__
from tests.kit.postgres import PostgreSQL
from tests.kit.process import ServerProcess
from tests.kit.serving import serving
from tests.kit.waiting import LIMIT, first_line, until

NAMELESS = "postgresql://nobody@/none?host={}"


def status(server: ServerProcess, path: str) -> int:
    """The status of a reply; 0 while nothing listens."""
    assert server.running.poll() is None, "the server has ended"
    try:
        return server.get(path).status_code
    except httpx.TransportError:
        return 0


@pytest.fixture
def waiting(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server, not started yet, whose log and output the test reads."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    server = ServerProcess(flags=("--data", str(tmp_path)), options=pipes)
    yield server
    if server.process is not None:
        server.end(signal.SIGKILL)


@pytest.mark.postgresql
def test_a_test_s_server_starts_at_a_port_where_another_had_another_ledger(
    postgresql: PostgreSQL,
) -> None:
    with ServerProcess(postgresql.new_database()) as former:
        pass
    with ServerProcess(postgresql.new_database(), port=former.port) as server:
        assert status(server, "/readyz") == 200


@pytest.mark.postgresql
def test_a_server_waits_for_its_database_and_is_not_ready_until_it_answers(
    postgresql: PostgreSQL, waiting: ServerProcess
) -> None:
    waiting.ledger = postgresql.new_database()
    postgresql.end()
    try:
        waiting.begin()
        until(lambda: status(waiting, "/readyz") == 503)
        assert status(waiting, "/healthz") == 200
        refused = waiting.get("/api/v1/boards")
        assert (refused.status_code, refused.json()["code"]) == (503, "ledger-unavailable")
    finally:
        postgresql.start()
    until(lambda: status(waiting, "/readyz") == 200)
    assert waiting.end() == 0
    assert waiting.said[0] == f"Plinko is at {waiting.url}/\n"
    assert waiting.said[1].count("waiting for the ledger") == 1


def test_a_server_that_waits_stops_at_once(waiting: ServerProcess, tmp_path: Path) -> None:
    waiting.ledger = NAMELESS.format(tmp_path)
    waiting.begin()
    until(lambda: status(waiting, "/readyz") == 503)
    assert waiting.end() in (0, -signal.SIGTERM)
    assert "Plinko is at" not in waiting.said[0]


def test_the_log_has_a_line_of_the_start_and_one_of_the_stop(waiting: ServerProcess) -> None:
    secret = "a secret of at least 32 characters"
    waiting.flags = ("--log-level", "info", "--log-format", "json", "--max-balls", "7")
    waiting.environment = {"PLINKO_SECRET": secret}
    waiting.ledger = "sqlite://"
    waiting.begin()
    listening = json.loads(first_line(waiting.running))
    assert waiting.end() == 0
    assert waiting.said[0] == ""
    assert (listening["event"], listening["address"]) == ("listening", f"{waiting.url}/")
    lines = [json.loads(line) for line in waiting.said[1].splitlines()]
    (start,) = (line for line in lines if line["event"] == "started")
    assert (start["version"], start["ledger"]) == (__version__, "sqlite://")
    assert start["settings"]["max_balls"] == 7
    assert secret not in waiting.said[1]
    assert lines[-1]["event"] == "stopped"


@pytest.mark.postgresql
def test_a_database_that_refuses_the_settings_is_not_waited_for(postgresql: PostgreSQL) -> None:
    assert Database(postgresql.url("no_such_database")).missing() is None
    assert Database(postgresql.new_database()).missing() is None


def serve(*flags: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "plinko", "serve", "--port", "0", *flags]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--board", "nope"], "board 'nope'"),
        (["--webhooks", "nope.json"], "nope.json"),
        (["--trusted-proxies", "nope"], "'nope'"),
        (["--database-url", "mysql://nope"], "mysql"),
        (["--hosts", "https://a.example"], "'https://a.example' is not a host name"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_wrong_settings_end_with_2_at_the_check(
    flags: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["serve", *flags, "--check"]) == 2
    out, err = capsys.readouterr()
    assert (out, said in err) == ("", True)


def test_what_ends_a_server_at_its_start_is_json_too() -> None:
    """The start goes through the same check."""
    done = serve("--log-format", "json", "--board", "nope")
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = map(json.loads, done.stderr.splitlines())
    assert (line["level"], "board 'nope'" in line["event"]) == ("critical", True)


def test_the_check_opens_no_port_and_no_ledger(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ledger = f"sqlite:///{tmp_path}/new/plinko.db"
    check = ["serve", "--check", "--database-url", ledger]
    assert main(check) == 0
    assert not (tmp_path / "new").exists()
    with serving(database_url=ledger) as server:
        capsys.readouterr()
        assert main([*check, "--port", server.url.rpartition(":")[2]]) == 0
    assert capsys.readouterr().out == "the settings are valid\n"


def test_the_service_manager_is_told_of_start_life_and_stop(
    waiting: ServerProcess, tmp_path: Path
) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.settimeout(LIMIT)
        manager.bind(str(tmp_path / "notify"))
        watched = {"NOTIFY_SOCKET": str(tmp_path / "notify"), "WATCHDOG_USEC": "20000"}
        waiting.environment = {**waiting.environment, **watched}
        waiting.begin()
        said = [manager.recv(100).decode() for _ in range(4)]
        assert said.count("READY=1") == 1
        assert said.count("WATCHDOG=1") == 3
        waiting.send(signal.SIGTERM)
        while manager.recv(100) != b"STOPPING=1":
            pass
        assert waiting.ended() == 0
