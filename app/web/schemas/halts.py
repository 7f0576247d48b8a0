"""Bodies of the routes that halt tables."""

from typing import Annotated

import msgspec
from msgspec import Meta


class HaltRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Halt a table, or let it go on."""

    halted: Annotated[bool, Meta(description="False lets it go on.")]
    room: Annotated[str | None, Meta(description="Which; null, or nothing, is all of them.")] = None


class HaltedTable(msgspec.Struct, frozen=True):
    """A table that takes no drops."""

    room: str
    since: Annotated[float, Meta(description="Unix time, in s.")]


class HaltView(msgspec.Struct, frozen=True):
    """What takes no drops now."""

    all_since: Annotated[
        float | None, Meta(description="Since when all tables are halted, Unix time in s.")
    ]
    rooms: Annotated[list[HaltedTable], Meta(description="Those halted by themselves.")]
