"""What Dask runs in each local worker as it starts: Ctrl-C is for the client, which ends it."""

import signal
from typing import Any


def dask_setup(_worker: Any) -> None:
    """Heed no interrupt; the name is the one that Dask looks for in a module to preload."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
