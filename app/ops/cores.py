"""Cores: one of them is the event loop's, where there are several."""

import os


def leave_one() -> None:
    """Keep off one core with the thread that calls this, and with what it starts.

    Of those that it has: once for each thread or process, so not for one that starts others.
    For threads and processes that compute beside the event loop: when a tick is due, it has that
    core at once. Else the scheduler lets whoever has a core go on to its next timer tick, 4 ms
    later, however polite; and it shares fairly, so the loop, which has had most, waits for the
    threads of its own process. Nothing where the system cannot see to it, or there is one core.
    """
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[1:] or cores)
