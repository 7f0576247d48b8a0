"""Clients by address: which addresses count as one client, and which are proxies. Pure."""

import functools
import ipaddress
import re
from collections import Counter
from collections.abc import Iterable

from plinko.app.errors import AppError, BusyError, ConnectionLimitError, SettingError
from plinko.engine.errors import shorten

_ALWAYS = 3  # connections that each client may have even when few are left
_FORWARDED = re.compile(r"\[([^\]]*)\](?::[0-9]+)?|([0-9.]+):[0-9]+")
"""A client as proxies write it with a port; some always do (`[2001:db8::1]:4711`)."""

_SITE = 64  # bits of an IPv6 network: one subscriber may use any address in it


@functools.lru_cache(maxsize=1024)
def one_client(host: str) -> str:
    """The key of a client: its IPv4 address, or its IPv6 network of 64 bits."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host  # not an internet address: a Unix socket's
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    return str(ipaddress.ip_network((int(address), _SITE), strict=False))


class Proxies:
    """The trusted proxies, as addresses or networks: the server believes their X-Forwarded-For.

    Raises SettingError for a text that is neither.
    """

    def __init__(self, trusted: Iterable[str]) -> None:
        names = list(trusted)
        try:
            self._networks = [ipaddress.ip_network(each, strict=False) for each in names]
        except ValueError as error:
            raise SettingError(
                f"trusted_proxies {shorten(names)}: {error}", field="trusted_proxies"
            ) from None
        self._trusts = functools.lru_cache(maxsize=1024)(self._is_inside)

    def __contains__(self, host: str) -> bool:
        return bool(self._networks) and self._trusts(host)

    def _is_inside(self, host: str) -> bool:
        try:
            address = ipaddress.ip_address(host)
        except ValueError:
            return False
        mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
        return any((mapped or address) in network for network in self._networks)

    def client_of(self, forwarded: str) -> str | None:
        """The client's address by X-Forwarded-For; None if what stands there is no address.

        Each proxy appends the address that it sees, so the client is the last one that is not a
        trusted proxy. Everything before it may be made up.
        """
        client = None
        for text in reversed(forwarded.split(",")):
            client = _address(text.strip())
            if client is None or client not in self:
                break
        return client


@functools.lru_cache(maxsize=256)
def _address(text: str) -> str | None:
    """The address in `text`, without a port; None if it is not an address."""
    match = _FORWARDED.fullmatch(text)
    try:
        return str(ipaddress.ip_address((match[1] or match[2]) if match else text))
    except ValueError:
        return None


class Connections:
    """Counts open connections and limits them: `most` for one client, `total` for all together.

    When few are left, one client may have only a tenth of those, so that a few clients cannot use
    up the rest. A trusted proxy speaks for many clients, so only the total limits it.
    """

    def __init__(self, most: int, proxies: Proxies, total: int = 1_000_000) -> None:
        self.most = most
        self.total = total
        self._count = 0
        self._proxies = proxies
        self._open: Counter[str] = Counter()

    def enter(self, host: str) -> bool:
        """Count one more connection of this address; False if it has too many already."""
        if self.refusal(host) is not None:
            return False
        self._open[one_client(host)] += 1
        self._count += 1
        return True

    def refusal(self, host: str) -> AppError | None:
        """Why this address cannot have one more connection; None if it can."""
        if self._count >= self.total:
            return BusyError(
                f"all {self._count} connections of the server are in use; try again later"
            )
        if host in self._proxies:
            return None
        has = self._open.get(one_client(host), 0)
        if has >= min(self.most, max(_ALWAYS, (self.total - self._count) // 10)):
            return ConnectionLimitError(
                f"this address has {has} connections open already; close one first"
            )
        return None

    def leave(self, host: str) -> None:
        """A connection that was counted has ended."""
        key = one_client(host)
        self._count -= 1
        self._open[key] -= 1
        if self._open[key] <= 0:
            del self._open[key]

    def __len__(self) -> int:
        return self._count
