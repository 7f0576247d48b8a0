"""The main loop of a worker process: read work from a socket, do it, send back the outcome."""

import contextlib
import os
import pickle
import re
import resource
import signal
import socket
import time
from pathlib import Path
from typing import Final

from plinko.app.computing.packing import BEGUN, REPLY, REQUEST
from plinko.app.errors import CostError

MEMORY: Final = 256 << 20
"""Bytes that a worker may allocate beyond those it started with."""

KEPT: Final = 32 << 20
"""Bytes beyond those at its start. A worker that has more after its work ends: a large picture
leaves memory that is not all returned to the system, and a new worker takes only milliseconds."""

_POLITE: Final = 10  # niceness: on a busy machine the event loop gets its time first


def serve(line: socket.socket) -> None:
    """Do the work that arrives on the socket `line` until it is closed."""
    # The fork server keeps the server's priority, because a server that stops waits for it.
    os.nice(_POLITE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends its workers
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    begun_with = _data()
    _limit_memory(begun_with)
    with line, line.makefile("rb") as stream, contextlib.suppress(OSError):
        ends = False
        while not ends and len(head := stream.read(REQUEST.size)) == REQUEST.size:
            size, seconds = REQUEST.unpack(head)
            work = stream.read(size)
            if len(work) < size:
                return
            line.sendall(BEGUN)
            # The system's timer ends work that takes too long: no kernel looks at a clock.
            signal.setitimer(signal.ITIMER_PROF, seconds)
            began = time.process_time()
            outcome, exhausted = _outcome(work)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            ends = exhausted or _data() - begun_with > KEPT
            spent = time.process_time() - began
            line.sendall(REPLY.pack(len(outcome), spent, ends) + outcome)


def _outcome(work: bytes) -> tuple[bytes, bool]:
    """The pickled value or error, and whether the work ran out of memory."""
    try:
        return _pickled(pickle.loads(work)(), None), False
    except MemoryError:
        why = f"this takes more memory than the {MEMORY >> 20} MB that a request may use"
        return _pickled(None, CostError(why)), True
    except Exception as raised:  # noqa: BLE001 - the server raises it again for the caller
        error = raised
    try:
        return _pickled(None, error), False
    except (TypeError, AttributeError, pickle.PicklingError) as failed:
        return _pickled(None, RuntimeError(f"{error!r}: {failed}")), False


def _pickled(value: object, error: Exception | None) -> bytes:
    return pickle.dumps((value, error), pickle.HIGHEST_PROTOCOL)


def _data() -> int:
    """Bytes of private data of this process; 0 if the system does not report it."""
    statistics = Path("/proc/self/status")
    if not statistics.exists():
        return 0
    (line,) = re.findall(r"^VmData:\s+([0-9]+) kB$", statistics.read_text(), re.MULTILINE)
    return int(line) * 1024


def _limit_memory(begun_with: int) -> None:
    """Make allocations beyond MEMORY fail with MemoryError, if the system reports the start."""
    if begun_with:
        limit = begun_with + MEMORY
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
