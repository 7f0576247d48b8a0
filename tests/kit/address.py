"""Where a server is, and the clients that talk to it."""

import httpx

from tests.kit.waiting import LIMIT

# Shorter than the server's five seconds: it must not close a connection while a request is sent.
LIMITS = httpx.Limits(keepalive_expiry=2.0)


class Address:
    url: str

    def socket(self, room: str = "main", query: str = "") -> str:
        return f"ws{self.url.removeprefix('http')}/ws/rooms/{room}{query}"

    def client(self, path: str = "") -> httpx.Client:
        """An HTTP client that prefixes this path to its addresses."""
        return httpx.Client(base_url=f"{self.url}{path}", timeout=LIMIT, limits=LIMITS)

    def async_client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(base_url=self.url, timeout=LIMIT, limits=LIMITS)

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"{self.url}{path}", timeout=LIMIT)
