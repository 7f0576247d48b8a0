"""Work that goes on when whoever asked for it has gone away."""

import asyncio
import logging
from collections.abc import Coroutine
from typing import TypeVar

from app.errors import LeaseLostError

T = TypeVar("T")

_log = logging.getLogger("plinko")


async def to_the_end(work: Coroutine[None, None, T]) -> T:
    """What comes of `work`, which is not cancelled with the one who waits for it.

    What the ledger is told and what memory then holds must not come apart in between.
    """
    doing = asyncio.ensure_future(work)
    try:
        return await asyncio.shield(doing)
    except asyncio.CancelledError:
        doing.add_done_callback(log_failure)
        raise


def log_failure(done: "asyncio.Future[T]") -> None:
    """Log that work failed which nobody waits for any more.

    Not where its room has gone to another server: that is logged once for the room.
    """
    if done.cancelled() or (error := done.exception()) is None:
        return
    if not isinstance(error, LeaseLostError):
        _log.warning("what nobody waits for any more failed: %s", error)
