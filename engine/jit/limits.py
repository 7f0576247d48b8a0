"""Limits how much one call of a kernel may compute, in processes that serve others.

The limit counts WebAssembly instructions, so that the same calls end on every machine, however busy
it is. Counting takes a seventh more time, so it is off by default.
"""

from collections.abc import Callable
from contextvars import ContextVar
from threading import Event
from typing import Final, TypeVar, TypeVarTuple

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

MOST: Final = 4_000_000_000
"""Instructions in a limited call, some 0.4 s. A step of 500 balls takes a thousandth of that; a
step of 300 balls that were all put into one place takes three quarters."""

_limited: Final = Event()
_most: Final[ContextVar[int]] = ContextVar("most", default=MOST)


def limit_calls() -> None:
    """End each later call of a kernel with EffortError after MOST instructions.

    For a process that serves others. Must be called before the first call of a kernel.
    """
    _limited.set()


def are_limited() -> bool:
    return _limited.is_set()


def at_most(instructions: int, work: Callable[[*Ts], T], *values: *Ts) -> T:
    """`work(*values)` with another limit for its calls; no effect if calls are not limited."""
    usual = _most.set(instructions)
    try:
        return work(*values)
    finally:
        _most.reset(usual)


def most() -> int:
    """Instructions that a call may take in the current context."""
    return _most.get()
