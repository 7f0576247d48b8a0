"""For which hosts the server answers: a foreign name in a request is DNS rebinding. Pure.

A page of another site can have its own name resolve to this machine; its scripts then ask this
server, and the browser takes that for the page's own site. Only the name tells them apart.
"""

import ipaddress
import re
from collections.abc import Iterable

from app.errors import HostError, shorten

_LOCAL = "localhost"
_NAME = re.compile(r"[a-z0-9_]([a-z0-9_.-]*[a-z0-9_])?")
_HEADER = re.compile(r"(?P<host>\[[^\[\]]*\]|[^:\[\]]*)(:(?P<port>\d{0,5}))?")


def host_of(header: str) -> str | None:
    """The host in a Host header or an origin's authority, in lower case; None when it is none.

    An IPv6 address comes without its brackets, a name without the dot that may end it.
    """
    found = _HEADER.fullmatch(header.strip().lower())
    if found is None:
        return None
    host = found["host"]
    if host.startswith("["):
        return host[1:-1] if _is_address(host[1:-1]) else None
    host = host.removesuffix(".")
    return host if _NAME.fullmatch(host) else None


class Hosts:
    """The hosts that may be asked for.

    Those are `localhost` and the addresses of this machine's loopback; the address that the server
    listens on, or any address when it listens on all; and the names that it was told: `name`,
    `*.domain` for every name below one, `*` for anything.
    """

    def __init__(self, listening: str, named: Iterable[str], machine: str = "") -> None:
        self._everywhere = listening in ("0.0.0.0", "::", "")
        names = {_LOCAL, listening.lower()}
        if self._everywhere and machine:
            # A name without a dot is nobody's in the DNS, one in .local is of this network.
            short = machine.lower().partition(".")[0]
            names |= {short, f"{short}.local"}
        given = [each.lower() for each in named]
        self._anything = "*" in given
        self._names = names | {each for each in given if not each.startswith("*")}
        self._below = tuple(each[1:] for each in given if each.startswith("*."))

    def check(self, header: str | None) -> None:
        """Raise HostError unless a request with this Host header is for this server.

        A request without one comes from no browser.
        """
        if header is None or self._anything:
            return
        host = host_of(header)
        if host is None or not self._knows(host):
            raise HostError(
                f"host {shorten(header, 100)} is not a name of this server; the setting `hosts` "
                "(--hosts) adds one",
                field="host",
            )

    def _knows(self, host: str) -> bool:
        if _is_address(host):
            address = ipaddress.ip_address(host)
            return self._everywhere or address.is_loopback or host in self._names
        return (
            host in self._names
            or host.endswith(f".{_LOCAL}")
            or (bool(self._below) and host.endswith(self._below))
        )


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
