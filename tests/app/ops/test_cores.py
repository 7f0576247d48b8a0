"""What computes beside the event loop leaves it a core."""

import os
import threading

import pytest

from app.live.ticking.step_threads import StepThreads
from app.ops.cores import leave_one
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
