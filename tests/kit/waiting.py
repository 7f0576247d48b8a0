"""Waiting for a condition, with an end: what has not come about by then never will.

Tests wait here for what they need, never for a time.
"""

import asyncio
import select
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import AnyStr

LIMIT = 120.0
"""s after which a test has failed that waited for something, on however slow a machine.

A server may have to compile the physics before it says where it is.
"""

PAUSE = 0.01
"""s between the first two looks at a condition; each is GROWTH times as long as the one before."""

GROWTH = 1.25
LONGEST = 0.1
"""s between two looks at most: whoever looks all the time slows down what is waited for."""


def first_line(process: "subprocess.Popen[AnyStr]") -> AnyStr:
    """What a server says once it can be used; ends it and fails when nothing comes."""
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], LIMIT)[0]:
        process.kill()
        raise AssertionError(f"process {process.args!r} said nothing within {LIMIT:.0f} s")
    return process.stdout.readline()


def lives(pid: int) -> bool:
    """Whether there is such a process that is not only waited for."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # the latter if it goes while it is read
        return False


def until(condition: Callable[[], object], pause: Callable[[], object] | None = None) -> None:
    """Look again and again until the condition holds; `pause` is called between two looks."""
    end = time.monotonic() + LIMIT
    pauses = _pauses()
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited {LIMIT:.0f} s in vain")
        if pause is None:
            time.sleep(next(pauses))
        else:
            pause()


async def eventually(condition: Callable[[], object]) -> None:
    """`until` for tests whose event loop goes on meanwhile."""
    async with asyncio.timeout(LIMIT):
        pauses = _pauses()
        while not condition():
            await asyncio.sleep(next(pauses))


def _pauses() -> Iterator[float]:
    pause = PAUSE
    while True:
        yield pause
        pause = min(pause * GROWTH, LONGEST)


async def turns(count: int = 20) -> None:
    """Let the event loop go round so often: all that needs no time has happened then."""
    for _ in range(count):
        await asyncio.sleep(0)
