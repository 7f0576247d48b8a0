"""Dask runs this when a local worker starts: Ctrl-C then reaches only the client, which ends it."""

import signal
from typing import Any


def dask_setup(_worker: Any) -> None:
    """Ignore interrupts. Dask calls the function of this name in a preloaded module."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
