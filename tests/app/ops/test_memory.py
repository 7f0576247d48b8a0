"""Memory that is let go goes back to the system, at moments when nobody waits."""

import asyncio
import ctypes
import itertools
import os
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

from app.ops import memory
from app.ops.memory import Collector, give_back
from tests.waiting import eventually, turns

STATISTICS = Path("/proc/self/statm")


def resident() -> int:
    """Bytes of this process that are in memory."""
    return int(STATISTICS.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(
    not (STATISTICS.exists() and hasattr(ctypes.CDLL(None), "malloc_trim")),
    reason="the C library cannot be told",
)
def test_what_lies_between_pieces_in_use_goes_back() -> None:
    pieces = [b"x" * 65_536 for _ in range(1000)]
    del pieces[:-1]  # the last one stays, at the end of all
    before = resident()
    give_back()
    assert resident() < before - 40e6


async def test_it_is_given_back_where_something_was_done_and_only_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given: list[int] = []
    done = [0]
    monkeypatch.setattr(memory, "give_back", lambda: given.append(done[0]))
    monkeypatch.setattr(memory, "_EVERY", 0.0)
    task = asyncio.create_task(memory.give_back_regularly(lambda: done[0]))
    for done[0] in (1, 2):
        await eventually(lambda: given[-1:] == done)
    await turns(100)
    assert given.count(2) == 1, "nothing was done since"
    task.cancel()


async def test_it_is_not_begun_shortly_before_a_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    now, period = 0.0, 0.0161803
    given: list[float] = []

    async def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds
        await asyncio.sleep(0)

    def due_in() -> float:
        return period - now % period

    monkeypatch.setattr(memory, "give_back", lambda: given.append(due_in()))
    numbers = itertools.count()
    task = asyncio.create_task(memory.give_back_regularly(lambda: next(numbers), due_in, sleep))
    await eventually(lambda: len(given) >= 100)
    task.cancel()
    assert 0.006 <= min(given) < 0.010 < max(given), "else at any moment"


_HEAPS: Final = """
import ctypes, threading
from app.ops import memory

if {shared}:
    memory.share_one_heap()
gate = threading.Barrier(5)

def allocate() -> None:
    pieces = [bytearray(50_000) for _ in range(100)]
    gate.wait()
    gate.wait()

threads = [threading.Thread(target=allocate) for _ in range(4)]
for thread in threads:
    thread.start()
gate.wait()
ctypes.CDLL(None).malloc_stats()
gate.wait()
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "mallopt"), reason="the C library cannot be told"
)
def test_threads_share_one_heap() -> None:
    heaps = []
    for shared in (False, True):
        code = [sys.executable, "-c", _HEAPS.format(shared=shared)]
        told = subprocess.run(code, capture_output=True, text=True, check=True)
        heaps.append(told.stderr.count("Arena "))
    assert heaps[0] > 1 == heaps[1]


class Collections:
    """A clock that is set, and how often everything was looked through."""

    def __init__(self) -> None:
        self.now = 0.0
        self.made = 0
        self.collector = Collector(lambda: self.now, self.make)

    def make(self) -> int:
        self.made += 1
        return 0

    def after(self, seconds: float, *, late: float = 0.0, duration: float = 0.001) -> int:
        """Collections made by the end of a tick so many s after the last one looked at."""
        self.now += seconds
        self.collector.ticked(late, duration)
        return self.made


def test_garbage_is_looked_for_after_a_short_tick_every_ten_seconds() -> None:
    all_ = Collections()
    assert [all_.after(seconds) for seconds in (9.0, 2.0, 2.0, 9.0)] == [0, 1, 1, 2]


def test_it_waits_for_a_short_tick_but_not_for_ever() -> None:
    all_ = Collections()
    assert all_.after(12.0, duration=0.008) == 0
    assert all_.after(1.0, late=0.006) == 0
    assert all_.after(1.0) == 1
    assert all_.after(29.0, duration=0.008) == 1
    assert all_.after(2.0, duration=0.008) == 2
