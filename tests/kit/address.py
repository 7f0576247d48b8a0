"""Where a server is, and the clients that talk to it."""

import httpx

from tests.kit.waiting import LIMIT


class Address:
    url: str

    def socket(self, room: str = "main", query: str = "") -> str:
        return f"ws{self.url.removeprefix('http')}/ws/rooms/{room}{query}"

    def client(self, path: str = "") -> httpx.Client:
        """An HTTP client that prefixes this path to its addresses."""
        return httpx.Client(base_url=f"{self.url}{path}", timeout=LIMIT)

    def async_client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(base_url=self.url, timeout=LIMIT)

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"{self.url}{path}", timeout=LIMIT)
