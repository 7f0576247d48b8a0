"""Where a server is, and the clients that talk to it."""

import httpx

from tests.kit.waiting import LIMIT


class Address:
    """A server at `url`."""

    url: str

    def socket(self, room: str = "main", query: str = "") -> str:
        """The address of a room's WebSocket."""
        return f"ws{self.url.removeprefix('http')}/ws/rooms/{room}{query}"

    def client(self, path: str = "") -> httpx.Client:
        """An HTTP client whose addresses begin with this path."""
        return httpx.Client(base_url=f"{self.url}{path}", timeout=LIMIT)

    def async_client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(base_url=self.url, timeout=LIMIT)

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"{self.url}{path}", timeout=LIMIT)
