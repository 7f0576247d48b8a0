"""The image has a pinned Python, and every package that `deploy/compose.yaml` needs."""

import json
import re
import subprocess
import tomllib
from urllib.parse import urlsplit

from tests.deploy.proxies import DEPLOY
from tests.kit.serving import serving

ROOT = DEPLOY.parent
DOCKERFILE = (ROOT / "Dockerfile").read_text()
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def test_both_stages_are_of_one_pinned_python() -> None:
    build, final = re.findall(r"^FROM (\S+)", DOCKERFILE, re.MULTILINE)
    assert build == final
    assert re.fullmatch(r"python:3\.13\.\d+-slim-[a-z]+\$\{DIGEST\}", final)
    # An argument before the first FROM is the only kind that FROM sees.
    assert DOCKERFILE.index("\nARG DIGEST=\n") < DOCKERFILE.index("\nFROM ")
    named = re.findall(r"inspect .* (\S+)$", DOCKERFILE, re.MULTILINE)
    assert named == [final.removesuffix("${DIGEST}")], "the command in the comment looks it up"


def test_the_image_has_every_part_that_a_service_imports() -> None:
    (chosen,) = re.findall(r"^ARG EXTRAS=(.+)$", DOCKERFILE, re.MULTILINE)
    had = {re.split(r"[\[><=;]", line)[0] for extra in chosen.split(",") for line in EXTRAS[extra]}
    # Needed by a cluster's server, a ledger on PostgreSQL, and a relay.
    assert {"httpx", "psycopg", "redis"} <= had
    assert not {"av", "dask", "numba"} & had, "large, and no service needs them"


def test_a_change_of_the_source_does_not_install_the_dependencies_again() -> None:
    build = DOCKERFILE.rpartition("\nFROM ")[0]
    before, _, after = build.partition("COPY engine engine\n")
    assert "-c constraints.txt" in before
    assert "COPY app" not in before
    assert "install --no-cache-dir --no-deps" in after


def test_the_health_check_asks_healthz_and_starts_no_python() -> None:
    (command,) = re.findall(r"HEALTHCHECK.*?CMD (\[.*?\])\n", DOCKERFILE, re.DOTALL)
    words = json.loads(command)
    with serving() as server:
        here = [word.replace("/8000", f"/{urlsplit(server.url).port}") for word in words]
        assert subprocess.run(here, check=False).returncode == 0
    assert subprocess.run(here, capture_output=True, check=False).returncode != 0


def test_nothing_in_the_image_installs_anything() -> None:
    final = DOCKERFILE.rpartition("FROM ")[2]
    assert "pip uninstall --yes" in final
    assert "rm -r /usr/local/lib/python3.13/ensurepip" in final
    assert "venv --without-pip" in DOCKERFILE
