"""Ctrl-C and SIGTERM stop a run between two blocks, not while a block is written and counted."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final, NoReturn

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


class Terminated(KeyboardInterrupt):
    """SIGTERM has arrived; the program ends like after Ctrl-C, which finishes its files."""


@contextmanager
def terminable() -> Iterator[None]:
    """Have SIGTERM raise Terminated instead of ending the process at once."""
    before = signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _terminate(_number: int, _frame: FrameType | None) -> NoReturn:
    raise Terminated


@contextmanager
def undisturbed() -> Iterator[None]:
    """Postpone both signals to the end of the `with` block."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread is interrupted
        return
    with collected(lambda: None) as came:
        yield
    for number in came[:1]:
        signal.raise_signal(number)


@contextmanager
def collected(note: Callable[[], None]) -> Iterator[list[int]]:
    """Collect both signals instead of dying, and call `note` at each."""
    came: list[int] = []

    def add(number: int, _frame: FrameType | None) -> None:
        came.append(number)
        note()

    before = {each: signal.signal(each, add) for each in _SIGNALS}
    try:
        yield came
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
