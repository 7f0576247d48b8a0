"""Small commands run kernels as Python: they end before compiled ones would be loaded.

The bits are the same, and nothing need be compiled before a first drop.
"""

import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

SWITCH = "NUMBA_DISABLE_JIT"

PATIENCE = 3.0
"""Seconds, a hundred drops' worth, after which a command starts again with compiled kernels."""


@contextmanager
def kernels_as_python(has_process: bool) -> Iterator[None]:
    """Run kernels as Python in this block, which must not have printed anything before its end.

    For a process of the command's own, `has_process`, where the engine is not imported yet and all
    may be started again; elsewhere, and if the user has set NUMBA_DISABLE_JIT, nothing is changed.
    """
    if not has_process or SWITCH in os.environ or not hasattr(signal, "setitimer"):
        yield
        return
    os.environ[SWITCH] = "1"
    signal.signal(signal.SIGALRM, _start_again)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        with warnings.catch_warnings():
            # Kernels compute on with infinities, as machine code does, where numpy would speak up.
            warnings.simplefilter("ignore", RuntimeWarning)
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _start_again(*_: object) -> None:
    os.environ[SWITCH] = "0"
    os.execv(sys.executable, sys.orig_argv)
