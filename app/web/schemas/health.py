"""Bodies of the routes that say how the server is."""

from typing import Any

import msgspec


class TickerHealth(msgspec.Struct, frozen=True):
    """The ticker's counts since the start."""

    asleep: bool
    ticks: int
    wakeups: int
    overruns: int
    skipped: int


class Health(msgspec.Struct, frozen=True):
    """That the process answers, and its clock's counts."""

    status: str
    version: str
    physics_version: Any
    ticker: TickerHealth


class Readiness(msgspec.Struct, frozen=True):
    """Whether the server can take drops; each check by itself."""

    ready: bool
    checks: dict[str, bool]
