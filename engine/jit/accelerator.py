"""Numba's code in place of an artifact's in long computations, where that takes less time.

To compile it takes a quarter of a minute, in a process beside this one: meanwhile the artifact
works on. The bits are the same, so that nobody has to know which of them ran.
"""

from enum import Enum, auto
from importlib import import_module
from importlib.util import find_spec
from threading import Event, Lock
from typing import Any, Final

from engine.jit.decorator import IS_OFF

_forbidden: Final = Event()


def forbid() -> None:
    """Keep to the artifacts from now on: this process is to stay small and never to halt."""
    _forbidden.set()


class State(Enum):
    """How far an accelerator has come."""

    WAITING = auto()
    COMPILING = auto()
    DONE = auto()  # numba's code runs
    OFF = auto()  # it never will: there is no numba, it is forbidden, or it could not compile


class Accelerator:
    """Of one kernel, told what it has done.

    kernel: its name, `engine.exact.trace.trace_many`. play: which of engine/artifact/plays.py calls
    it, and so tells numba its types. enough: an amount of work, beside which what it takes to
    compile is small.
    """

    def __init__(self, kernel: str, play: str, enough: float) -> None:
        self.kernel = kernel
        self.play = play
        self.enough = enough
        self.state = State.WAITING
        self.compilation: Any = None
        self._work = 0.0
        self._lock = Lock()

    def did(self, work: float) -> None:
        """So much more has been done. What comes next may be done by numba's code.

        It returns at once, but for the one time when that code is loaded.
        """
        if self.state in {State.DONE, State.OFF} or not self._lock.acquire(blocking=False):
            return
        try:
            self._work += work
            if self.state is State.WAITING and self._work >= self.enough:
                self.state = self._begun()
            elif self.state is State.COMPILING and self.compilation.done:
                self.state = State.DONE if self.compilation.use() else State.OFF
        finally:
            self._lock.release()

    def _begun(self) -> State:
        if IS_OFF or _forbidden.is_set() or find_spec("numba") is None:
            return State.OFF
        beside = import_module("engine.jit.compilation")
        try:
            self.compilation = beside.Compilation(self.kernel, self.play)
        except OSError:  # no room for another process: the artifact goes on
            return State.OFF
        return State.COMPILING
