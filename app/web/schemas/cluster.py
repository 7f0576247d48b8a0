"""Bodies of what is of several servers over one ledger."""

from typing import Annotated

import msgspec
from msgspec import Meta


class MoveRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Which server is to have a room."""

    to: Annotated[str, Meta(description="The server's `--name`.")]


class MoveView(msgspec.Struct, frozen=True):
    """A room and the server that it was given to."""

    room: str
    server: str


class ClusterView(msgspec.Struct, frozen=True):
    """How a server stands among the others."""

    name: str
    leases: Annotated[bool, Meta(description="Whether it sees the other servers.")]
    servers: Annotated[list[str], Meta(description="Those that are alive, by name.")]
    rooms: Annotated[int, Meta(description="Rooms that are this server's.")]
