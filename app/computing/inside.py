"""A worker process from within: takes work from a pipe, does it, sends back what came of it."""

import contextlib
import re
import resource
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final

from app.ops import memory

MEMORY: Final = 256 << 20
"""Bytes that a worker may take beyond what it was started with."""

KEPT: Final = 32 << 20
"""Bytes beyond that, with which a worker ends when its work is done: what a large picture took is
not all given back otherwise, and another worker is there within milliseconds."""

WALL: Final = 6.0
"""Times the s that something may compute after which it is ended whatever it has computed: where
others keep the machine busy, a worker, being polite, may wait for long."""

_GRACE: Final = 1  # s after that at which the system ends a worker nobody waits for


def serve(pipe: Connection) -> None:
    """Do what comes through the pipe until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    begun_with = _data()
    _limit_memory(begun_with)
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            work, seconds = pipe.recv()
            # Its end is the system's business: no kernel looks at a clock.
            signal.setitimer(signal.ITIMER_PROF, seconds)
            signal.setitimer(signal.ITIMER_REAL, WALL * seconds + _GRACE)
            began = time.process_time()
            answer = _answer(work)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            memory.give_back()
            ends = _data() - begun_with > KEPT
            _send(pipe, (*answer, time.process_time() - began, ends))
            if ends:
                return


def _answer(work: Any) -> tuple[bool, Any]:
    try:
        return True, work()
    except Exception as error:  # noqa: BLE001 - it is raised again where it was asked for
        return False, error


def _send(pipe: Connection, answer: tuple[bool, Any, float, bool]) -> None:
    try:
        pipe.send(answer)
    except (TypeError, AttributeError) as error:  # what cannot be pickled
        pipe.send((False, RuntimeError(f"{answer[1]!r}: {error}"), *answer[2:]))


def _data() -> int:
    """Bytes of memory that this process has to itself; 0 where the system does not tell."""
    statistics = Path("/proc/self/status")
    if not statistics.exists():
        return 0
    (line,) = re.findall(r"^VmData:\s+([0-9]+) kB$", statistics.read_text(), re.MULTILINE)
    return int(line) * 1024


def _limit_memory(begun_with: int) -> None:
    """Let what takes too much fail by itself, where the system can tell how much that is."""
    if begun_with:
        limit = begun_with + MEMORY
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
