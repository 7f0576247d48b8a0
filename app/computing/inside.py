"""A worker process from within: reads work from a socket, does it, sends back the outcome."""

import contextlib
import pickle
import re
import resource
import signal
import socket
import time
from pathlib import Path
from typing import Final

from app.computing.packing import BEGUN, REPLY, REQUEST
from app.errors import CostError

MEMORY: Final = 256 << 20
"""Bytes that a worker may take beyond what it was started with."""

KEPT: Final = 32 << 20
"""Bytes beyond that, with which a worker ends when its work is done: what a large picture took is
not all given back otherwise, and another worker is there within milliseconds."""

_GRACE: Final = 1.0  # s after its real time at which the system ends a worker nobody waits for


def serve(line: socket.socket) -> None:
    """Do what comes over the line until it is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    begun_with = _data()
    _limit_memory(begun_with)
    with line, line.makefile("rb") as stream, contextlib.suppress(OSError):
        ends = False
        while not ends and len(head := stream.read(REQUEST.size)) == REQUEST.size:
            size, core, real = REQUEST.unpack(head)
            work = stream.read(size)
            if len(work) < size:
                return
            line.sendall(BEGUN)
            # Its end is the system's business: no kernel looks at a clock.
            signal.setitimer(signal.ITIMER_PROF, core)
            signal.setitimer(signal.ITIMER_REAL, real + _GRACE)
            began = time.process_time()
            outcome, exhausted = _outcome(work)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            ends = exhausted or _data() - begun_with > KEPT
            spent = time.process_time() - began
            line.sendall(REPLY.pack(len(outcome), spent, ends) + outcome)


def _outcome(work: bytes) -> tuple[bytes, bool]:
    """The pickled value or error, and whether the memory was not enough."""
    try:
        return _pickled(pickle.loads(work)(), None), False
    except MemoryError:
        return _pickled(None, CostError("it takes more memory than a request may")), True
    except Exception as raised:  # noqa: BLE001 - it is raised again where it was asked for
        error = raised
    try:
        return _pickled(None, error), False
    except (TypeError, AttributeError, pickle.PicklingError) as why:
        return _pickled(None, RuntimeError(f"{error!r}: {why}")), False


def _pickled(value: object, error: Exception | None) -> bytes:
    return pickle.dumps((value, error), pickle.HIGHEST_PROTOCOL)


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
