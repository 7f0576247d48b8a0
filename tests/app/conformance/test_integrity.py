"""The program's digests depend on its files and settings, and on nothing else."""

import asyncio
import hashlib
import json
import logging
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from plinko.app.cli import main
from plinko.app.conformance import inventory
from plinko.app.conformance.inventory import Digests
from plinko.app.conformance.self_check import DAY, SelfCheck
from plinko.app.settings import Settings
from tests.app.conftest import PLENTY
from tests.kit.serving import Running
from tests.kit.waiting import eventually

SETTINGS = Settings()


@pytest.fixture
def roots(tmp_path: Path) -> dict[str, Path]:
    """A small program, with the pages inside the server's package as in a wheel."""
    app, engine = tmp_path / "app", tmp_path / "engine"
    for folder in (app / "static", app / "__pycache__", engine):
        folder.mkdir(parents=True)
    (app / "main.py").write_text("run()\n")
    (app / "__pycache__" / "main.pyc").write_bytes(b"compiled")
    (app / "static" / "index.html").write_text("<p>Plinko\n")
    (engine / "exact.wasm").write_bytes(b"\0asm")
    return {"app": app, "engine": engine, "static": app / "static"}


def test_files_go_by_the_same_names_wherever_the_pages_lie(roots: dict[str, Path]) -> None:
    packaged = inventory.files_of(roots)
    assert [*sorted(packaged)] == ["app/main.py", "engine/exact.wasm", "static/index.html"]
    apart = roots["app"].parent / "static"
    roots["static"].rename(apart)
    assert inventory.files_of({**roots, "static": apart}) == packaged


def test_the_list_is_what_sha256sum_checks(roots: dict[str, Path]) -> None:
    files = inventory.files_of(roots)
    (roots["app"].parent / "static").symlink_to(roots["static"])
    checked = subprocess.run(
        ["sha256sum", "--check", "--strict"],
        input=inventory.listed(files),
        cwd=roots["app"].parent,
        env={"PATH": os.defpath},  # `make check` has only Python's programs in its own
        capture_output=True,
        text=True,
        check=True,
    )
    assert checked.stdout.count(": OK") == len(files) == 3


@pytest.mark.parametrize(
    ("changed", "group"), [("app/main.py", "code"), ("engine/exact.wasm", "kernels")]
)
def test_a_changed_byte_shows_in_its_group_and_in_the_whole(
    roots: dict[str, Path], changed: str, group: str
) -> None:
    before = inventory.digests_of(inventory.files_of(roots), {})
    (roots["app"].parent / changed).write_bytes(b"\1asm")
    after = inventory.digests_of(inventory.files_of(roots), {})
    groups = {name for name, value in after.to_dict().items() if value != before.to_dict()[name]}
    assert groups == {group, "whole"}


def test_the_first_file_that_differs_is_named() -> None:
    files = {"app/a.py": "1" * 64, "app/b.py": "2" * 64}
    found = inventory.first_difference
    assert found(files, inventory.from_list(inventory.listed(files))) is None
    assert found(files, {**files, "app/a.py": "3" * 64}) == (
        f"app/a.py differs: {'1' * 64}, not {'3' * 64}"
    )
    assert found(files, {"app/b.py": "2" * 64}) == "app/a.py is not in the list"
    assert found({}, files) == "app/a.py is missing"


def test_the_configuration_has_all_but_secrets_and_places(tmp_path: Path) -> None:
    told = inventory.configuration_of(SETTINGS)
    assert told["board"] == "triangle-16"
    assert not {"secret", "metrics_token", "data", "port"} & told.keys()
    assert {"max_balls", "creator_rooms", "tick_rate", "hosts"} <= told.keys()
    digest = inventory.digests_of({}, told).configuration
    assert (
        digest
        != inventory.digests_of(
            {}, inventory.configuration_of(replace(SETTINGS, max_balls=201))
        ).configuration
    )
    same = replace(SETTINGS, port=80, secret="s" * 32, data=str(tmp_path))
    assert inventory.digests_of({}, inventory.configuration_of(same)).configuration == digest


def test_a_board_in_a_file_counts_by_its_content(tmp_path: Path) -> None:
    board = tmp_path / "board.json"
    board.write_text("{}")
    told = inventory.configuration_of(replace(SETTINGS, board=str(board)))
    assert told["board"] == hashlib.sha256(b"{}").hexdigest()


# The command.


def test_the_command_says_what_a_server_says(
    server: Running, http: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    told = http.get("/api/v1/integrity").json()
    flags = [
        part
        for name, value in PLENTY.items()
        for part in (f"--{name.replace('_', '-')}", str(value))
    ]
    assert main(["integrity", *flags, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert told["unchanged"] is True
    assert told["at_start"] == told["whole"] == printed["whole"]
    assert {name: printed[name] for name in ("code", "kernels", "configuration")} == {
        name: told[name] for name in ("code", "kernels", "configuration")
    }
    assert (
        printed["files"]["engine/seeding.py"]
        == hashlib.sha256(Path("engine/seeding.py").read_bytes()).hexdigest()
    )
    assert server.services.self_check.sound


def test_the_command_compares_with_a_list(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["integrity", "--files"]) == 0
    lines = capsys.readouterr().out
    own = tmp_path / "list"
    own.write_text(lines)
    assert main(["integrity", "--compare", str(own)]) == 0
    assert capsys.readouterr().out.startswith("all ")
    own.write_text(lines.replace("  engine/seeding.py", "  engine/seedling.py"))
    assert main(["integrity", "--compare", str(own)]) == 1
    assert capsys.readouterr().out == "engine/seeding.py is not in the list\n"
    own.write_text("engine\n")
    assert main(["integrity", "--compare", str(own)]) == 2
    assert "line 1, 'engine', is not a SHA-256" in capsys.readouterr().err


# The server checks its files at the start and daily.


class Clock:
    """A clock whose sleeps end when the test sets `turn`."""

    def __init__(self) -> None:
        self.now = 1000.0
        self.slept: list[float] = []
        self.woken = 0
        self.turn = asyncio.Event()

    def waits(self) -> bool:
        return len(self.slept) > self.woken and not self.turn.is_set()

    async def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        await self.turn.wait()
        self.turn.clear()
        self.woken += 1
        self.now += seconds


async def test_it_checks_at_start_and_daily_and_reports_changes(
    caplog: pytest.LogCaptureFixture,
) -> None:
    clock = Clock()
    found = [Digests("a", "b", "c"), Digests("a", "b", "c"), Digests("z", "b", "c")]
    first, last = found[0].whole, found[-1].whole
    check = SelfCheck(lambda: found.pop(0), now=lambda: clock.now, sleep=clock.sleep)
    with caplog.at_level(logging.INFO, "plinko"):
        task = asyncio.create_task(check.run())
        for _ in range(2):
            await eventually(clock.waits)
            clock.turn.set()
        await eventually(lambda: not check.sound)
        task.cancel()
    assert clock.slept[:2] == [DAY, DAY]
    assert [vars(line)["digest"] for line in caplog.records if line.levelname == "INFO"][:2] == [
        first,
        first,
    ]
    (error,) = [line.getMessage() for line in caplog.records if line.levelname == "ERROR"]
    assert first in error
    assert last in error
    assert check.last is not None
    assert check.last.to_dict() | {"at": 0.0} == {
        **Digests("z", "b", "c").to_dict(),
        "at": 0.0,
        "at_start": first,
        "unchanged": False,
    }


async def test_simultaneous_callers_read_the_files_once() -> None:
    looks: list[None] = []

    def look() -> Digests:
        looks.append(None)
        return Digests("a", "b", "c")

    check = SelfCheck(look, now=lambda: 5.0)
    findings = await asyncio.gather(*(check.look() for _ in range(5)))
    assert len(looks) == 1
    assert len(set(map(id, findings))) == 1
