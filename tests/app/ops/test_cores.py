"""What computes beside the event loop leaves it a core."""

import os
import platform
import re
import threading
from pathlib import Path
from typing import Final

import pytest

from app.live.ticking.step_threads import StepThreads
from app.ops.cores import leave_one, wait_as_usual, wake_at_once
from tests.waiting import eventually

pytestmark = pytest.mark.skipif(
    not hasattr(os, "sched_setaffinity"), reason="the system sees to no thread's cores"
)


def test_a_thread_keeps_off_one_core_and_no_other_thread_does() -> None:
    before = os.sched_getaffinity(0)
    found: list[set[int]] = []

    def beside() -> None:
        leave_one()
        found.append(os.sched_getaffinity(0))

    thread = threading.Thread(target=beside)
    thread.start()
    thread.join()
    rest = set(sorted(before)[1:]) or before
    assert found == [rest]
    assert os.sched_getaffinity(0) == before


async def test_rooms_steps_are_computed_on_the_other_cores() -> None:
    found: list[set[int]] = []
    threads = StepThreads(1)
    threads.submit("room", lambda: found.append(os.sched_getaffinity(0)), lambda: None)
    await eventually(lambda: found)
    threads.close()
    before = os.sched_getaffinity(0)
    assert found == [set(sorted(before)[1:]) or before]


_OWN: Final = Path("/proc/thread-self/sched")


def slice_of_thread() -> int:
    """ns that a thread has a core for, at most, where others want it."""
    (found,) = re.findall(r"^se\.slice\s*:\s*(\d+)$", _OWN.read_text(), re.MULTILINE)
    return int(found)


def asks_for_slices() -> bool:
    """Whether this is Linux from 6.12 on, and tells how it shares cores."""
    if not (_OWN.exists() and "se.slice" in _OWN.read_text()):
        return False
    major, minor = platform.release().split(".")[:2]
    return (int(major), int(minor)) >= (6, 12)


@pytest.mark.skipif(not asks_for_slices(), reason="the system knows nothing of it")
def test_who_is_to_wake_at_once_has_short_slices_and_so_has_what_it_starts() -> None:
    usual, nice = slice_of_thread(), os.getpriority(os.PRIO_PROCESS, 0)
    found: list[int] = []

    def note() -> None:
        found.append(slice_of_thread())

    def computes() -> None:
        wait_as_usual()
        note()

    def wakes() -> None:
        wake_at_once()
        note()
        for beside in (note, computes):
            thread = threading.Thread(target=beside)
            thread.start()
            thread.join()
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

    thread = threading.Thread(target=wakes)
    thread.start()
    thread.join()
    assert found == [100_000, 100_000, usual, nice]
    assert slice_of_thread() == usual
