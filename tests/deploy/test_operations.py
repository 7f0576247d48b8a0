"""The operator's page: its unit file starts, its backup is restored, its alerts exist."""

import configparser
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml
from click.testing import CliRunner

from plinko.app.cli import EXIT_BAD_INPUT, main, plinko
from plinko.app.listening import SHUTDOWN_SECONDS
from plinko.app.settings import Settings, not_settings
from tests.app.conftest import QUICK
from tests.deploy.proxies import DEPLOY
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT

PAGE = (DEPLOY.parent / "docs" / "operations.md").read_text()


def unit() -> dict[str, str]:
    parser = configparser.ConfigParser(strict=False)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(DEPLOY / "plinko.service")
    return dict(parser["Service"])


def test_the_unit_s_server_stops_cleanly_and_writes_where_it_may() -> None:
    service = unit()
    program, *command = service["ExecStart"].split()
    assert program == "/opt/plinko/bin/plinko"
    done = CliRunner().invoke(plinko, [*command, "--help"])
    assert done.exit_code == 0, done.output
    data = command[command.index("--data") + 1]
    assert data == f"/var/lib/{service['StateDirectory']}"
    assert int(service["TimeoutStopSec"]) > SHUTDOWN_SECONDS
    assert service["PrivateTmp"] == "yes", "its workers need a directory for temporary files"


def test_the_unit_exposes_little_and_tries_again_unless_a_setting_is_wrong() -> None:
    service = unit()
    assert service["RestartPreventExitStatus"] == str(EXIT_BAD_INPUT)
    assert service["Type"] == "notify"
    analyse = shutil.which("systemd-analyze")
    if analyse is None:
        pytest.skip("systemd-analyze is not here: apt-get install systemd")
    command = [analyse, "security", "--offline=true", "--threshold=25", "--no-pager"]
    done = subprocess.run([*command, DEPLOY / "plinko.service"], capture_output=True, check=False)
    assert done.returncode == 0, done.stdout.decode()


def test_the_environment_of_the_page_is_of_settings() -> None:
    (block,) = re.findall(r"```text\n(PLINKO_HOSTS.*?)```", PAGE, re.DOTALL)
    given = dict(line.split("=", 1) for line in block.splitlines())
    assert not_settings(given) == []
    filled = {name: value.replace("…", "x" * 32) for name, value in given.items()}
    assert Settings.load(filled).hosts == ("plinko.example",)


def test_each_alert_and_only_alerts_have_instructions() -> None:
    groups = yaml.safe_load((DEPLOY / "alerts.yml").read_text())["groups"]
    there = [rule["alert"] for group in groups for rule in group["rules"]]
    said = re.findall(r"^\| `(Plinko\w+)` \|", PAGE, re.MULTILINE)
    assert sorted(said) == sorted(there)


def test_every_file_of_deploy_that_the_page_names_is_there() -> None:
    named = set(re.findall(r"`(deploy/[\w./-]+)`", PAGE))
    assert {"deploy/plinko.service", "deploy/nginx.conf", "deploy/Caddyfile"} <= named
    assert [each for each in named if not (DEPLOY.parent / each).exists()] == []


def at(server: Running, path: str, **options: Any) -> httpx.Response:
    return httpx.request(
        options.pop("method", "GET"), f"{server.url}/api/v1{path}", timeout=LIMIT, **options
    )


def test_a_documented_backup_restores_rooms_tokens_and_keys(tmp_path: Path) -> None:
    home, copy, archive = tmp_path / "home", tmp_path / "FILE", tmp_path / "secrets.tar"
    places = {"/var/lib/plinko": str(home), "FILE": str(copy), "secrets.tar": str(archive)}

    def commands(program: str) -> list[list[str]]:
        """The page's commands that begin so, with the places of this test."""
        lines = re.findall(rf"^{program} [^\n#]*", PAGE, re.MULTILINE)
        found = [shlex.split(line) for line in lines]
        return [[places.get(word, word.replace("/var/lib/plinko", str(home))) for word in words]
                for words in found]  # fmt: skip

    _, with_secrets, *_ = commands("plinko ledger backup")
    (install,), (unpack,) = commands("install"), commands("tar --extract")
    ledger = {"data": str(home), "database_url": ""}
    with serving(**ledger) as server:
        made = at(server, "/rooms", method="POST", json={"board": QUICK}).json()
        shown = {"authorization": f"Bearer {made['token']}"}
        room = f"/rooms/{made['id']}"
        landed = at(server, f"{room}/drops?wait=1", method="POST", json={"seed": "1"}).json()
        key = signing_key(home)
        file = ["--database-url", f"sqlite:///{home}/plinko.db"]
        assert main([*with_secrets[1:], *file]) == 0
        at(server, f"{room}/drops?wait=1", method="POST", json={"seed": "2"})
    secrets = {"plinko.db-secret", "plinko.db-secret-signing-key"}
    left = {path.name for path in home.iterdir()} - {*secrets, "plinko.db-lock", "plinko.db-epoch"}
    (gone,) = re.findall(r"delete ((?:`plinko\.db[\w-]*`(?:, | and )?)+)", PAGE)
    assert left <= set(re.findall(r"`([^`]+)`", gone)), "nothing of the former ledger stays"
    shutil.rmtree(home)  # only the backup is left
    home.mkdir()
    for command in (install, unpack):
        subprocess.run(command, check=True)
    assert {path.name for path in home.iterdir()} == {"plinko.db", *secrets}
    assert "plinko ledger restore --data" in PAGE
    assert main(["ledger", "restore", *file]) == 0
    with serving(**ledger) as server:
        drops = at(server, f"{room}/log").json()["drops"]
        assert [each["result"]["digest"] for each in drops] == [landed["landed"]["digest"]]
        assert at(server, f"{room}/reset", method="POST", headers=shown).is_success
        assert signing_key(home) == key


def signing_key(home: Path) -> bytes:
    return (home / "plinko.db-secret-signing-key").read_bytes()
