"""One worker process as the server sees it: started when needed, ended when it takes too long."""

import multiprocessing
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerProcess
from typing import Any, Final

from app.computing.inside import WALL, serve
from app.computing.packing import packed
from app.errors import CostError, DeadlineError, EndedError

PRELOADED: Final = ["app.computing.polite", "app.computing.preloaded"]

_context = multiprocessing.get_context("forkserver")


@dataclass(frozen=True, slots=True)
class Done:
    """An answer of a worker: a value, or the error that came of it; and the s it computed."""

    value: Any
    error: Exception | None
    seconds: float


def prepare() -> None:
    """Begin to load what workers need, in a process of its own; returns at once."""
    _context.set_forkserver_preload(PRELOADED)
    forkserver.ensure_running()


class WorkerProcess:
    """A process that does one thing at a time. `do` is for a thread, `end` for any."""

    def __init__(self) -> None:
        self._process: ForkServerProcess | None = None
        self._pipe: Connection | None = None
        self._ended = False
        self._lock = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Of the process, if there is one."""
        process = self._process
        return None if process is None else process.pid

    def do(self, work: Callable[[], Any], seconds: float) -> Done:
        """What came of `work()`; blocks. `work` is a function of a module, with picklable values.

        Raises DeadlineError when it computes for more than so many s of a core, or does not come
        to its end for WALL times as long; EndedError when the process ended by itself or by `end`.
        Another is started the next time.
        """
        try:
            pipe = self._started()
            pipe.send_bytes(packed(work, seconds))
            if not pipe.poll(WALL * seconds):
                self._stop()
                raise _too_long(seconds)
            fine, value, spent, ends = pipe.recv()
        except (EOFError, OSError) as error:
            if self._stop() == -signal.SIGPROF:
                raise _too_long(seconds) from error
            raise EndedError("the process that computed it ended") from error
        if ends or isinstance(value, MemoryError):
            self._stop()
        if isinstance(value, MemoryError):
            raise CostError("it takes more memory than a request may")
        return Done(value, None, spent) if fine else Done(None, value, spent)

    def end(self) -> None:
        """End the process at once, whatever it does; none is started any more."""
        with self._lock:
            self._ended = True
            self._kill()

    def _started(self) -> Connection:
        if self._process is not None and not self._process.is_alive():
            self._stop()  # it was ended while it had nothing to do
        if self._pipe is None:
            prepare()
            ours, theirs = _context.Pipe()
            process = _context.Process(target=serve, args=(theirs,), daemon=True)
            process.start()
            theirs.close()
            with self._lock:
                self._process, self._pipe = process, ours
        if self._ended:
            self._stop()
            raise EndedError("nobody waits for it any more")
        return self._pipe

    def _kill(self) -> None:
        if self._process is not None:
            self._process.kill()

    def _stop(self) -> int | None:
        """Let go of the process, for the thread that waits for it; how it ended, if there is one.

        One that has ended by itself is not harmed.
        """
        with self._lock:
            self._kill()
            process, pipe = self._process, self._pipe
            self._process = self._pipe = None
        if pipe is not None:
            pipe.close()
        if process is None:
            return None
        process.join()
        code = process.exitcode
        process.close()
        return code


def _too_long(seconds: float) -> DeadlineError:
    return DeadlineError(f"it takes longer than the {seconds:g} s that a request may compute")
