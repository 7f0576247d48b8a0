"""How much one call of a kernel may compute, where whoever runs the process limits it.

Counted are instructions of WebAssembly, so that what is ended is the same on every machine, however
busy. Code that counts takes a seventh longer: nothing is counted where nobody asked for it.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event
from typing import Final

MOST: Final = 4_000_000_000
"""Instructions in a call, where calls are limited: some 0.4 s. A frame of 500 balls takes a
thousandth, and one of 300 that were put into one place three quarters."""

_limited: Final = Event()
_most: Final[ContextVar[int]] = ContextVar("most", default=MOST)


def limit_calls() -> None:
    """From now on each call of a kernel ends after MOST instructions, with EffortError.

    For a process that must go on whatever it is asked; to be said before the first call.
    """
    _limited.set()


def are_limited() -> bool:
    """Whether calls are."""
    return _limited.is_set()


@contextmanager
def at_most(instructions: int) -> Iterator[None]:
    """Calls in the block end after so many instead, where calls are limited."""
    usual = _most.set(instructions)
    try:
        yield
    finally:
        _most.reset(usual)


def most() -> int:
    """Instructions that a call may take here and now."""
    return _most.get()
