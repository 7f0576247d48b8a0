"""The server's side of one worker process: start it, send it work, kill it.

Work is sent in two phases. A worker that ends before it has answered BEGUN has done nothing, so
the same work may go to another worker. After BEGUN the work is never repeated.
"""

import asyncio
import contextlib
import multiprocessing
import os
import pickle
import signal
import socket
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing import forkserver
from pathlib import Path
from typing import Any, Final

from plinko.app.computing.inside import serve
from plinko.app.computing.packing import BEGUN, REPLY, REQUEST
from plinko.app.errors import DeadlineError, EndedError

PRELOADED: Final = ["plinko.app.computing.preloaded"]

_AT_ONCE: Final = 1 << 18  # bytes per read

_context = multiprocessing.get_context("forkserver")

_fork_server = ThreadPoolExecutor(1, "fork-server")
"""The only thread that waits for the fork server, which loads much at first. It is one thread
because an exit code can be read only once, and `multiprocessing` reads those of all its processes
whenever it starts another."""


@dataclass(frozen=True, slots=True)
class Done:
    """A worker's reply: the value, or the error that the work raised; and its CPU seconds."""

    value: Any
    error: Exception | None
    seconds: float


def prepare() -> None:
    """Start the fork server, which loads the workers' code; returns at once."""
    _context.set_forkserver_preload(PRELOADED)
    forkserver.ensure_running()


async def start() -> "WorkerProcess":
    """Start a worker; raises EndedError if the system cannot start a process."""
    starting = asyncio.get_running_loop().run_in_executor(_fork_server, WorkerProcess)
    try:
        return await asyncio.shield(starting)
    except asyncio.CancelledError:
        starting.add_done_callback(_unwanted)
        raise
    except (EOFError, OSError) as error:
        raise EndedError("the server could not start a process to compute this") from error


def _unwanted(starting: "asyncio.Future[WorkerProcess]") -> None:
    if starting.exception() is None:
        starting.result().end()


class WorkerProcess:
    """A process that does one job at a time. Constructed in a thread, used by the event loop."""

    def __init__(self) -> None:
        prepare()
        self._line, theirs = socket.socketpair()
        self._line.setblocking(False)
        self._process = _context.Process(target=serve, args=(theirs,), daemon=True)
        try:
            self._process.start()
            self._handle = _handle(self.pid)
        except BaseException:
            self._line.close()
            raise
        finally:
            theirs.close()
        self.spent = 0.0  # CPU seconds that the last job took, or had taken when it was interrupted
        self.ends = False  # whether the process ends by itself after its last reply

    @property
    def pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    async def do(self, work: bytes, seconds: float) -> Done | None:
        """Send packed work and return the reply, or None if the process ended before it began.

        Raises DeadlineError if the work takes more than `seconds` CPU seconds; EndedError if the
        process ended after it had begun. After these, or if cancelled, the worker is unusable.
        """
        self.spent, before, begun = 0.0, self._used(), False
        try:
            request = REQUEST.pack(len(work), seconds) + work
            await asyncio.get_running_loop().sock_sendall(self._line, request)
            begun = await self._read(len(BEGUN)) == BEGUN
            size, self.spent, self.ends = REPLY.unpack(await self._read(REPLY.size))
            value, error = pickle.loads(await self._read(size))
        except asyncio.CancelledError:
            self.spent = min(max(self._used() - before, 0.0), seconds)
            raise
        except (EOFError, OSError) as gone:
            if not begun:
                return None
            if await self._exit_code() == -signal.SIGPROF:
                self.spent = seconds
                raise DeadlineError(
                    f"this takes longer than the {seconds:g} s that a request may compute"
                ) from gone
            raise EndedError("the process that computed this ended") from gone
        return Done(value, error, self.spent)

    def kill(self) -> None:
        """Kill the process at once; a running `do` then raises."""
        with contextlib.suppress(ProcessLookupError):
            if self._handle is None:
                os.kill(self.pid, signal.SIGKILL)
            else:
                signal.pidfd_send_signal(self._handle, signal.SIGKILL)

    def end(self) -> None:
        """Kill the process and release its socket and handle."""
        self.kill()
        self._line.close()
        if self._handle is not None:
            os.close(self._handle)

    def _used(self) -> float:
        """CPU seconds of the process until now; 0 if it has ended.

        Where the system does not report them, the clock's time stands for them.
        """
        if sys.platform != "linux":
            return time.monotonic()
        try:
            fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            return 0.0
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    async def _read(self, count: int) -> bytes:
        found = bytearray()
        while missing := count - len(found):
            loop = asyncio.get_running_loop()
            part = await loop.sock_recv(self._line, min(missing, _AT_ONCE))
            if not part:
                raise EOFError
            found += part
        return bytes(found)

    async def _exit_code(self) -> int | None:
        # The process has closed its socket. If it still runs, joining it would block the thread.
        self.kill()
        await asyncio.get_running_loop().run_in_executor(_fork_server, self._process.join)
        return self._process.exitcode


def _handle(pid: int) -> int | None:
    """A pidfd, which never refers to a later process with the same pid; None where unavailable."""
    try:
        return os.pidfd_open(pid) if sys.platform == "linux" else None
    except ProcessLookupError:
        raise
    except OSError:  # before Linux 5.3, or in a sandbox that forbids it
        return None
