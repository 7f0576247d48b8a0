"""How routes see the other servers that share the ledger; `app/cluster/` implements it."""

from dataclasses import dataclass
from typing import Protocol

from starlette.types import ASGIApp


@dataclass(frozen=True, slots=True)
class Standing:
    """A server's place in its cluster.

    `leases` is whether it can see which servers are alive, `rooms` the number of rooms it has.
    Since the start, `failed_over` and `migrated` count rooms, and `forwarded` requests.
    """

    name: str
    leases: bool
    members: list[str]
    rooms: int
    failed_over: int
    migrated: int
    forwarded: int


class Others(Protocol):
    """What this server can do with the others of its cluster."""

    name: str

    @property
    def joined(self) -> bool:
        """Whether the other servers know of this one."""

    @property
    def first(self) -> bool:
        """Whether this server does the work that one server does for all."""

    def surround(self, app: ASGIApp) -> ASGIApp:
        """`app` within the layer that forwards requests to the server that has their room."""

    def standing(self) -> Standing:
        """This server's place now."""

    async def move(self, room_id: str, to: str) -> str:
        """Give a room of this server to the one called `to`, and return that server's name.

        Raises InvalidValueError.
        """

    async def ask_all(self, path: str, part: str) -> list[object]:
        """Send GET `path` to every other server, and return the list `part` of each response.

        A server that does not answer is left out.
        """

    async def leave(self) -> None:
        """Give all rooms of this server to the others."""
