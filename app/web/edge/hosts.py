"""Checks the Host header against the server's own names, to stop DNS rebinding. Pure.

Another site can make its own name resolve to this machine. Its scripts can then send requests to
this server, and the browser believes that they go to the site itself. Only the name in the Host
header shows the difference.
"""

import functools
import ipaddress
import re
from collections.abc import Iterable

from plinko.app.errors import HostError
from plinko.engine.errors import shorten

_LOCAL = "localhost"
_NAME = re.compile(r"[a-z0-9_]([a-z0-9_.-]*[a-z0-9_])?")
_HEADER = re.compile(r"(?P<host>\[[^\[\]]*\]|[^:\[\]]*)(:(?P<port>\d{0,5}))?")


def host_of(header: str) -> str | None:
    """The host in a Host header or an origin's authority, in lower case; None if it is invalid.

    An IPv6 address is returned without brackets, a name without a final dot.
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
    """The hosts that this server answers for.

    They are `localhost` and the loopback addresses; the address that the server listens on, or any
    address if it listens on all; and the names in the settings: `name`, `*.domain` for every name
    below a domain, `*` for anything. A server that listens on all addresses also answers for its
    `machine` name.
    """

    def __init__(self, listening: str, named: Iterable[str], machine: str = "") -> None:
        self._everywhere = listening in ("0.0.0.0", "::", "")
        names = {_LOCAL, listening.lower()}
        if self._everywhere and machine:
            # No other site can own these: the public DNS has no name without a dot, and .local
            # names are resolved in the local network.
            short = machine.lower().partition(".")[0]
            names |= {short, f"{short}.local"}
        given = [each.lower() for each in named]
        self._anything = "*" in given
        self._names = names | {each for each in given if not each.startswith("*")}
        self._below = tuple(each[1:] for each in given if each.startswith("*."))
        self._accepts = functools.lru_cache(maxsize=256)(self._is_own)

    def check(self, header: str | None) -> None:
        """Raise HostError unless a request with this Host header is for this server.

        A request without the header is accepted: browsers always send it.
        """
        if header is None or self._anything:
            return
        if not self._accepts(header):
            raise HostError(
                f"host {shorten(header, 100)} is not a name of this server; the setting `hosts` "
                "(--hosts) can add it",
                field="host",
            )

    def _is_own(self, header: str) -> bool:
        host = host_of(header)
        if host is None:
            return False
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
