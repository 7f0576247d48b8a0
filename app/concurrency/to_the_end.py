"""Work that continues when its caller is cancelled, for example because a client disconnected."""

import asyncio
import logging
from collections.abc import Coroutine
from typing import TypeVar

from plinko.app.errors import LeaseLostError

T = TypeVar("T")

_log = logging.getLogger("plinko")


async def to_the_end(work: Coroutine[None, None, T]) -> T:
    """Await `work`; if the caller is cancelled, `work` still runs until it is done.

    Work that writes to the ledger and then updates memory must not stop between the two, or they
    would differ.
    """
    running = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(running)
    except asyncio.CancelledError:
        running.add_done_callback(log_failure)
        raise


def log_failure(done: "asyncio.Future[T]") -> None:
    """Log the failure of work whose caller has left.

    A LeaseLostError is not logged here: it is logged once for its room.
    """
    if done.cancelled() or (error := done.exception()) is None:
        return
    if not isinstance(error, LeaseLostError):
        _log.warning("work failed after its caller had left: %s", error)
