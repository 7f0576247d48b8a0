"""Logs when the server stood still: its process was stopped or starved, or it computed too long."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Final

_LOOK: Final = 0.5  # s
_LONG: Final = 2.0
"""s after which a line is logged: by then a commit would have been late, too."""

_log = logging.getLogger("plinko")


def _clock() -> float:
    """s of a clock that also runs while the machine is suspended, where there is one."""
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))


async def watch(
    *,
    clock: Callable[[], float] = _clock,
    unix: Callable[[], float] = time.time,
    worked: Callable[[], float] = time.process_time,
    sleep: Callable[[float], Awaitable[object]] = asyncio.sleep,
) -> None:
    """Look twice a second, until cancelled, how long the look before was ago.

    `computed` in the log line is the process's own processor time meanwhile. A machine whose clock
    was set is logged, too: it is the only sign that a virtual machine was paused.
    """
    while True:
        began, unix_began, worked_before = clock(), unix(), worked()
        await sleep(_LOOK)
        passed = clock() - began
        if passed - _LOOK > _LONG:
            about = {
                "seconds": round(passed - _LOOK, 1),
                "computed": round(worked() - worked_before, 1),
            }
            _log.warning("the server stood still", extra=about)
        jumped = unix() - unix_began - passed
        if abs(jumped) > _LONG:
            _log.warning("the machine's clock was set", extra={"seconds": round(jumped, 1)})
