"""The commands in `docs/growing.md` work; only addresses and amounts are replaced."""

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest

from plinko.app.settings import Settings, not_settings
from plinko.engine import Board, drop_many
from tests.deploy.proxies import DEPLOY
from tests.kit.port import free_port
from tests.kit.postgres import PostgreSQL
from tests.kit.process import OPERATOR, Program
from tests.kit.redis import MISSING, PROGRAM, Redis
from tests.kit.waiting import LIMIT, until

PAGE = (DEPLOY.parent / "docs" / "growing.md").read_text()
BIN = Path(sys.executable).parent


def commands(name: str, **replaced: str) -> list[list[str]]:
    """The commands of a block of the page; `replaced` has the texts to replace."""
    (block,) = re.findall(rf"<!-- run: {name} -->\n```text\n(.*?)```", PAGE, re.DOTALL)
    for old, new in replaced.items():
        place = old.replace("__", ":").replace("_", ".")
        assert place in block, place
        block = block.replace(place, new)
    return [shlex.split(line) for line in block.splitlines()]


def running(command: list[str], **environment: str) -> Program:
    return Program(command=[BIN / command[0], *command[1:]], environment=environment)


def at(port: int, path: str) -> httpx.Response | None:
    with contextlib.suppress(httpx.TransportError):
        return httpx.get(f"http://127.0.0.1:{port}{path}", timeout=LIMIT)
    return None


def is_up(port: int, path: str = "/healthz") -> Callable[[], bool]:
    def up() -> bool:
        answer = at(port, path)
        return answer is not None and answer.status_code == 200

    return up


@pytest.mark.postgresql
def test_three_servers_are_one(
    postgresql: PostgreSQL,
) -> None:
    ports = [free_port() for _ in range(3)]
    places = {f"port {8000 + k}": f"port {port}" for k, port in enumerate(ports)}
    places["http://127_0_0_1__8000"] = f"http://127.0.0.1:{ports[0]}"
    install, export, *serving, moving = commands("rooms", **places)
    assert install[:2] == ["pip", "install"]
    assert export[1].startswith("PLINKO_DATABASE_URL=postgresql://")
    own = {"PLINKO_DATABASE_URL": postgresql.new_database(), "PLINKO_OPERATOR_TOKEN": OPERATOR}
    with contextlib.ExitStack() as stack:
        for command in serving:
            stack.enter_context(running(command, **own))
        until(lambda: all(known(port) == ["a", "b", "c"] for port in ports))
        done = subprocess.run(
            [BIN / moving[0], *moving[1:]],
            env=os.environ | own,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, "b" in done.stdout) == (0, True), done.stderr
        for port in ports:
            made = httpx.post(
                f"http://127.0.0.1:{port}/api/v1/rooms/main/drops", json={}, timeout=LIMIT
            )
            assert made.status_code == 202, made.text
    restored = brought_back(postgresql, own["PLINKO_DATABASE_URL"])
    assert "sound: 1 room runs, 3 drops" in restored, "what was dropped is there"


def brought_back(postgresql: PostgreSQL, database: str) -> str:
    """Dump and restore a ledger as the operator's page says; returns what the commands print."""
    page = (DEPLOY.parent / "docs" / "operations.md").read_text()
    lines = re.findall(
        r"^(?:pg_dump|pg_restore|plinko ledger) .*postgresql://.*$", page, re.MULTILINE
    )
    said, place, data = "", "postgresql://plinko@db.example/plinko", "/var/lib/plinko"
    empty = postgresql.new_database()
    with tempfile.TemporaryDirectory() as folder:
        for line, address in zip(lines, (database, empty, empty, empty), strict=True):
            here = line.replace(place, address).replace(data, f"{folder}/data")
            program, *options = shlex.split(here)
            found = shutil.which(program, path=f"{BIN}:{postgresql.binaries}:{os.environ['PATH']}")
            assert found is not None, program
            done = subprocess.run(
                [found, *options], cwd=folder, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, f"{line}: {done.stderr}"
            said += done.stdout
    return said


def test_the_environment_of_a_server_among_others_is_of_settings() -> None:
    (block,) = re.findall(r"```text\n( *PLINKO_NAME.*?)```", PAGE, re.DOTALL)
    given = dict(line.strip().split("=", 1) for line in block.strip().splitlines())
    assert not_settings(given) == []
    settings = Settings.load(given)
    assert (settings.name, settings.host) == ("a", "0.0.0.0")
    in_proxy = set(re.findall(r"^ +(PLINKO_(?:BIND|\d))=", PAGE, re.MULTILINE))
    assert in_proxy <= set(re.findall(r"PLINKO_\w+", (DEPLOY / "haproxy.cfg").read_text()))
    assert len(in_proxy) == 4


def known(port: int) -> list[str]:
    answer = at(port, "/readyz")
    return answer.json()["cluster"]["servers"] if answer is not None else []


@pytest.mark.skipif(PROGRAM is None, reason=MISSING)
def test_relays_are_before_a_server() -> None:
    server, *relays = ports = [free_port() for _ in range(3)]
    with Redis() as redis, contextlib.ExitStack() as stack:
        block = commands(
            "relays",
            **{
                "redis://redis_example__6379": redis.url,
                "http://server_example__8000": f"http://127.0.0.1:{server}",
                "port 8000": f"port {server}",
                "port 8001": f"port {relays[0]}",
                "port 8002": f"port {relays[1]}",
            },
        )
        for command in block[1:]:
            stack.enter_context(running(command, PLINKO_DATABASE_URL="sqlite://"))
        until(lambda: all(is_up(port)() for port in ports))


def test_a_batch_on_workers_has_the_digest_that_it_has_here(tmp_path: Path) -> None:
    port, result = free_port(), tmp_path / "result.json"
    block = commands(
        "batches",
        **{
            "tcp://scheduler_example__8786": f"tcp://127.0.0.1:{port}",
            "--port 8786": f"--port {port} --no-dashboard --host 127.0.0.1",
            "--drops 1e9": "--drops 1000",
            "result_json": str(result),
            "--nworkers 2": "--nworkers 1 --no-dashboard",
        },
    )
    _, scheduler, worker, simulate = block
    with running(scheduler), running(worker):
        done: list[subprocess.CompletedProcess[str]] = []

        def computed() -> bool:
            done[:] = [
                subprocess.run(
                    [BIN / simulate[0], *simulate[1:], "--json"],
                    capture_output=True,
                    text=True,
                    check=False,
                )
            ]
            return done[0].returncode == 0  # it fails until a worker has connected

        until(computed)
    histogram = drop_many(Board.preset("triangle-16"), 1000).histogram
    assert f'"histogram": {list(map(int, histogram))}' in done[0].stdout
