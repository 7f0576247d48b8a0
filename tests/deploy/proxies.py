"""Run HAProxy, nginx and Caddy with the configurations in `deploy/`."""

import contextlib
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import httpx

from tests.kit.port import free_port
from tests.kit.process import Program

DEPLOY: Final = Path(__file__).parents[2] / "deploy"
NAME: Final = "plinko.example"
"""The site's name in the configurations."""

_WITH_NGINX: Final = """
daemon off;
pid {folder}/pid;
error_log {folder}/error;
events {{}}
http {{
  access_log off;
  client_body_temp_path {folder}/body;
  proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi;
  scgi_temp_path {folder}/scgi;
  {site}
}}
"""

_WITH_CADDY: Final = "{\n\tadmin off\n\tauto_https off\n}\n"


def program(name: str) -> str | None:
    """The path of a proxy's program; None if not installed."""
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin")


def replaced(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the configuration"
    return text.replace(old, new)


@contextlib.contextmanager
def haproxy(port: int, servers: Mapping[str, str], _: Path) -> Iterator[None]:
    """Run HAProxy; `servers`: HOST:PORT by variable, missing ones are replaced by the first."""
    first = servers["PLINKO_1"]
    places = {"PLINKO_2": first, "PLINKO_3": first} | dict(servers)
    places["PLINKO_BIND"] = f"127.0.0.1:{port}"
    with _running(["haproxy", "-db", "-f", str(DEPLOY / "haproxy.cfg")], places, port):
        yield


@contextlib.contextmanager
def nginx(port: int, servers: Mapping[str, str], folder: Path) -> Iterator[None]:
    site = replaced((DEPLOY / "nginx.conf").read_text(), "listen 80", f"listen 127.0.0.1:{port}")
    site = replaced(site, "http://127.0.0.1:8000", f"http://{servers['PLINKO_1']}")
    file = folder / "nginx.conf"
    file.write_text(_WITH_NGINX.format(folder=folder, site=site))
    with _running(["nginx", "-c", str(file), "-e", f"{folder}/error"], {}, port):
        yield


@contextlib.contextmanager
def caddy(port: int, servers: Mapping[str, str], folder: Path) -> Iterator[None]:
    site = (DEPLOY / "Caddyfile").read_text()
    site = replaced(site, "\nplinko.example {", f"\nhttp://{NAME}:{port} {{\n\tbind 127.0.0.1")
    site = replaced(site, "reverse_proxy 127.0.0.1:8000", f"reverse_proxy {servers['PLINKO_1']}")
    file = folder / "Caddyfile"
    file.write_text(_WITH_CADDY + site)
    home = {"HOME": str(folder), "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    command = ["caddy", "run", "--adapter", "caddyfile", "--config", str(file)]
    with _running(command, home, port):
        yield


PROXIES: Final = {"haproxy": haproxy, "nginx": nginx, "caddy": caddy}


@contextlib.contextmanager
def before(name: str, servers: Mapping[str, str], folder: Path) -> Iterator[int]:
    """Run the proxy of this name in front of these servers; gives its port."""
    port = free_port()
    with PROXIES[name](port, servers, folder):
        yield port


def _running(command: list[str], environment: Mapping[str, str], port: int) -> Program:
    found = program(command[0])
    assert found is not None

    def answers() -> bool:
        with contextlib.suppress(httpx.TransportError):
            found = httpx.get(f"http://127.0.0.1:{port}/", headers={"host": f"{NAME}:{port}"})
            return re.match("[1-4]", str(found.status_code)) is not None
        return False

    return Program(command=[found, *command[1:]], environment=dict(environment), answers=answers)
