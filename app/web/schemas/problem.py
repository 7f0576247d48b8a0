"""The body of every error: RFC 9457 problem details."""

from typing import Annotated

import msgspec
from msgspec import Meta


class FaultOf(msgspec.Struct, frozen=True):
    """One of several things that are wrong with a board."""

    field: Annotated[str, Meta(description="Where it is in the board's JSON.")]
    detail: str


class Problem(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error, as RFC 9457 problem details; `detail` names the bad value."""

    type: str
    title: str
    status: int
    detail: str
    code: Annotated[str, Meta(description="Stable slug of the kind of error.")]
    field: Annotated[str | None, Meta(description="Where the bad value is, if in one place.")] = (
        None
    )
    instance: str | None = None
    faults: Annotated[
        tuple[FaultOf, ...], Meta(description="Of a board with several faults: all of them.")
    ] = ()
