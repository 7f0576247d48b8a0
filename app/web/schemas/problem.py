"""The body of every error: RFC 9457 problem details."""

from typing import Annotated

import msgspec
from msgspec import Meta


class FaultOf(msgspec.Struct, frozen=True):
    """One of several faults of a board."""

    field: Annotated[str, Meta(description="The bad value's place in the board's JSON.")]
    detail: str


class Problem(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error, as RFC 9457 problem details; `detail` names the bad value."""

    type: str
    title: str
    status: int
    detail: str
    code: Annotated[str, Meta(description="The kind of error, a stable short name.")]
    field: Annotated[
        str | None, Meta(description="The bad value's place, if it is a single value.")
    ] = None
    instance: str | None = None
    faults: Annotated[
        tuple[FaultOf, ...], Meta(description="All faults of a board that has several.")
    ] = ()
