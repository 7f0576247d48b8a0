"""The Compose file names existing files and settings, and the servers of the proxy."""

import re
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import yaml
from click.testing import CliRunner

from plinko.app.cli import plinko
from plinko.app.settings import ENV_PREFIX, Settings
from plinko.app.web.edge.hosts import Hosts

DEPLOY = Path(__file__).parents[2] / "deploy"
COMPOSE: dict[str, Any] = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
SERVERS = {name: each for name, each in SERVICES.items() if "plinko" in name}
RELAYS = {name: each for name, each in SERVICES.items() if "relay" in name}
CLUSTERED = {name: each for name, each in SERVERS.items() if "cluster" in each.get("profiles", ())}
OURS = SERVERS | RELAYS


def variables(service: dict[str, Any]) -> dict[str, str]:
    """A service's environment with the defaults of variables that the shell does not set."""
    given = {name: str(value) for name, value in service["environment"].items()}
    filled = {name: re.sub(r"\$\{\w+:[-?](.*)\}", r"\1", value) for name, value in given.items()}
    return {name: value for name, value in filled.items() if value}


def test_every_file_that_a_service_gets_is_in_the_folder() -> None:
    mounted = [
        volume.partition(":")[0]
        for service in SERVICES.values()
        for volume in service.get("volumes", ())
    ]
    files = [each for each in mounted if each.startswith("./")]
    assert len(files) >= 5
    assert [each for each in files if not (DEPLOY / each).is_file()] == []
    named = {each for each in mounted if not each.startswith("./")}
    assert named == COMPOSE["volumes"].keys()


def test_images_are_of_one_version_and_servers_of_this_checkout() -> None:
    for name, service in SERVICES.items():
        if name in OURS:
            assert (DEPLOY / service["build"] / "Dockerfile").is_file()
        else:
            assert re.fullmatch(r"[\w/-]+:v?\d+(\.\d+)*", service["image"]), name


@pytest.mark.parametrize("name", OURS)
def test_what_is_ours_starts_with_settings_that_there_are(name: str) -> None:
    service = OURS[name]
    command = service["command"]
    assert command[:2] == ["plinko", "serve" if name in SERVERS else "relay"]
    # The command line refuses unknown options before it handles --help.
    done = CliRunner().invoke(plinko, [*command[1:], "--help"])
    assert done.exit_code == 0, done.output
    given = variables(service)
    assert {name for name in given if not name.startswith(ENV_PREFIX)} == set()
    known = Settings.load(given)
    assert {name for name in given if not getattr(known, name[7:].lower())} == set()


def test_relays_ask_the_servers_and_the_redis_that_are_started() -> None:
    assert len(RELAYS) == 2
    for service in RELAYS.values():
        redis, rooms = service["command"][2:4]
        assert urlsplit(redis).hostname in SERVICES
        assert urlsplit(rooms).hostname in SERVERS
        assert set(service["profiles"]) <= set(SERVICES["redis"]["profiles"])


def test_a_cluster_s_three_servers_differ_only_in_their_names() -> None:
    first, *others = SERVERS.values()
    assert len(SERVERS) == 3
    assert set(CLUSTERED) == set(SERVERS) - {"plinko1"}, "one server needs no profile"
    assert SERVICES["redis"]["profiles"] == ["relays"], "and these servers need none"
    for name, each in SERVERS.items():
        assert each["hostname"] == each["environment"]["PLINKO_NAME"] == name
    for other in others:
        assert other["command"] == first["command"]
        assert other["environment"] | {"PLINKO_NAME": "plinko1"} == first["environment"]


def test_the_proxy_and_prometheus_ask_what_is_started() -> None:
    proxy = (DEPLOY / "haproxy.cfg").read_text()
    asked = set(re.findall(r"\"\$\{PLINKO_\w+-(\w+):8000\}\"", proxy))
    assert asked >= OURS.keys()
    scraped = yaml.safe_load((DEPLOY / "prometheus.yml").read_text())["scrape_configs"]
    targets = {each["job_name"]: set(each["static_configs"][0]["targets"]) for each in scraped}
    assert targets == {
        "plinko": {f"{name}:8000" for name in SERVERS if name not in CLUSTERED},
        "cluster": {f"{name}:8000" for name in CLUSTERED},
        "relays": {f"{name}:8000" for name in RELAYS},
    }


def test_a_server_answers_under_the_name_that_prometheus_uses() -> None:
    for name, service in OURS.items():
        machine, command = service["hostname"], service["command"]
        listens = command[command.index("--host") + 1]
        Hosts(listens, Settings.load(variables(service)).hosts, machine).check(f"{name}:8000")


def test_the_proxy_is_trusted_and_stands_alone_in_its_network() -> None:
    (network,) = COMPOSE["networks"]["default"]["ipam"]["config"]
    for service in OURS.values():
        command = service["command"]
        assert command[command.index("--trusted-proxies") + 1] == network["subnet"]
        assert "ports" not in service, "who could reach it could name any address as its own"
