"""Waiting for a condition, with a time limit after which the test fails.

Tests wait for a condition, never for a fixed time.
"""

import asyncio
import select
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import AnyStr

LIMIT = 120.0
"""Seconds after which a waiting test fails; enough for a slow machine.

A server may have to compile the physics before it prints its address.
"""

PAUSE = 0.01
"""Seconds between the first two polls of a condition; each pause is GROWTH times the last."""

GROWTH = 1.25
LONGEST = 0.1
"""Longest pause in seconds. Polling more often would slow down the awaited program."""


def first_line(process: "subprocess.Popen[AnyStr]") -> AnyStr:
    """The line that a server prints when it is ready; kills it and fails if none comes."""
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], LIMIT)[0]:
        process.kill()
        raise AssertionError(f"process {process.args!r} said nothing within {LIMIT:.0f} s")
    return process.stdout.readline()


def lives(pid: int) -> bool:
    """Whether the process runs: it exists and is not a zombie."""
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):  # the latter if it ends while it is read
        return False


def until(condition: Callable[[], object], pause: Callable[[], object] | None = None) -> None:
    """Poll until the condition holds; `pause` is called between two polls."""
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
    """`until` for tests whose event loop must run meanwhile."""
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
    """Let the event loop run `count` iterations: all ready callbacks have then run."""
    for _ in range(count):
        await asyncio.sleep(0)
