"""Bodies of the routes for a cluster of servers."""

from typing import Annotated

import msgspec
from msgspec import Meta


class MoveRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The server that a room is to move to."""

    to: Annotated[str, Meta(description="The server's `--name`.")]


class MoveView(msgspec.Struct, frozen=True):
    """A room and the server that now has it."""

    room: str
    server: str


class ClusterView(msgspec.Struct, frozen=True):
    """A server's view of its cluster."""

    name: str
    leases: Annotated[bool, Meta(description="Whether it sees the other servers.")]
    servers: Annotated[list[str], Meta(description="The names of the servers that are alive.")]
    rooms: Annotated[int, Meta(description="Number of rooms that this server has.")]
