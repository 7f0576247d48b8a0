"""Cores: one of them is the event loop's, where there are several, and it has it at once."""

import contextlib
import ctypes
import os
import platform
import struct
from typing import Final

_SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}  # the system call's number
_SHORT: Final = 100_000  # ns; no slice is shorter. The usual one is 1.4 ms on two cores
_USUAL: Final = 0

_ATTRIBUTES: Final = struct.Struct("=IIQiIQQQII")
"""`struct sched_attr`: its size, policy, flags, nice, priority, runtime, and what is not used."""


def leave_one() -> None:
    """Keep off one core with the thread that calls this, and with what it starts.

    Of those that it has, so what it starts does not call this again.
    For threads and processes that compute beside the event loop: when a tick is due, it has that
    core at once. Else the scheduler lets whoever has a core go on to its next timer tick, 4 ms
    later, however polite; and it shares fairly, so the loop, which has had most, waits for the
    threads of its own process. Nothing where the system cannot see to it, or there is one core.
    """
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[1:] or cores)


def wake_at_once() -> None:
    """Have the thread that calls this, and those that it starts, run as soon as they wake.

    For the event loop and the threads beside it: when it lets one of them have the interpreter, it
    goes on only once that has taken it and let it go. They ask for short slices of time, in which
    they have no more of a core, but need not wait for the end of another thread's (earliest virtual
    deadline first; sched-eevdf.rst in Linux's documentation, from 6.12 on). Nothing where the
    system knows nothing of it, or the thread has a policy of its own.
    """
    _ask_for(_SHORT)


def wait_as_usual() -> None:
    """Undo `wake_at_once`, for a process that computes and was started by such a thread."""
    _ask_for(_USUAL)


def _ask_for(slice_: int) -> None:
    number = _SCHED_SETATTR.get(platform.machine())
    if not hasattr(os, "sched_getscheduler") or number is None:
        return
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    wanted = (_ATTRIBUTES.size, os.SCHED_OTHER, 0, nice, 0, slice_, 0, 0, 0, 0)
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).syscall(number, 0, _ATTRIBUTES.pack(*wanted), 0)
