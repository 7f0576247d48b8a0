"""What routes know of the other servers, where several share one ledger; see `app/cluster/`."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Standing:
    """How a server stands among the others.

    `leases` is whether it sees who is alive, `rooms` how many rooms are this server's;
    `taken_over` and `handed_over` count rooms since the start, `handed_on` requests.
    """

    name: str
    leases: bool
    members: list[str]
    rooms: int
    taken_over: int
    handed_over: int
    handed_on: int


class Peer(Protocol):
    """Another server."""

    @property
    def name(self) -> str:
        """What people call it."""


class Others(Protocol):
    """This server's end of what it shares with the others."""

    name: str

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""

    @property
    def first(self) -> bool:
        """Whether this server does what one of them does for all."""

    def standing(self) -> Standing:
        """How it stands now."""

    async def move(self, room_id: str, to: str) -> Peer:
        """Give a room that is here to the server of this name; raises InvalidValueError."""

    async def ask_all(self, path: str, part: str) -> list[object]:
        """What each of the others lists as `part` of its answer to a GET of this path.

        Nothing of one that does not answer.
        """

    async def leave(self) -> None:
        """Give all rooms to the others."""
