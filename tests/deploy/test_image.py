"""The image has a pinned Python, and every package that `deploy/compose.yaml` needs."""

import re
import tomllib

from tests.deploy.proxies import DEPLOY

ROOT = DEPLOY.parent
DOCKERFILE = (ROOT / "Dockerfile").read_text()
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def test_both_stages_are_of_one_pinned_python() -> None:
    build, final = re.findall(r"^FROM (\S+)", DOCKERFILE, re.MULTILINE)
    assert build == final
    assert re.fullmatch(r"python:3\.13\.\d+-slim-[a-z]+", final)


def test_the_image_has_every_part_that_a_service_imports() -> None:
    (chosen,) = re.findall(r"'\.\[(.+)\]'", DOCKERFILE)
    assert set(chosen.split(",")) == {
        *("server", "certify", "postgres", "redis", "batches", "video"),
    }
    had = {re.split(r"[\[><=;]", line)[0] for extra in chosen.split(",") for line in EXTRAS[extra]}
    # Needed by a cluster's server, a ledger on PostgreSQL, a relay, and a worker of batches.
    assert {"httpx", "psycopg", "redis", "dask"} <= had


def test_nothing_in_the_image_installs_anything() -> None:
    final = DOCKERFILE.rpartition("FROM ")[2]
    assert "pip uninstall --yes" in final
    assert "rm -r /usr/local/lib/python3.13/ensurepip" in final
    assert "venv --without-pip" in DOCKERFILE
