"""Cores: one of them is the event loop's, where there are several, and it has it at once."""

import contextlib
import ctypes
import os
import platform
import struct
from typing import Final


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


_SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}  # the system call's number
_NO_CHILD: Final = 1  # SCHED_FLAG_RESET_ON_FORK
_SLICE: Final = 100_000  # ns; the shortest there is. The usual one is 1.4 ms on two cores

ATTRIBUTES: Final = struct.Struct("=IIQiIQQQII")
"""`struct sched_attr`: its size, policy, flags, nice, priority, runtime, and what is not used."""


def wake_at_once() -> None:
    """Have the thread that calls this run as soon as it wakes, whoever has its core.

    For the event loop's: it asks for shorter slices of time, in which it has no more of them, but
    need not wait for the end of another thread's (earliest virtual deadline first; sched-eevdf.rst
    in Linux's documentation, from 6.12 on). Neither its threads nor its processes do. Nothing where
    the system knows nothing of it, or the thread has a policy of its own.
    """
    number = _SCHED_SETATTR.get(platform.machine())
    if not hasattr(os, "sched_getscheduler") or number is None:
        return
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    wanted = (ATTRIBUTES.size, os.SCHED_OTHER, _NO_CHILD, nice, 0, _SLICE, 0, 0, 0, 0)
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).syscall(number, 0, ATTRIBUTES.pack(*wanted), 0)
