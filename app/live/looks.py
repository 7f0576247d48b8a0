"""Looks that are made once for all who ask while they last."""

import asyncio
import functools
from collections.abc import Callable, Coroutine
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Looks(Generic[T]):
    """For the event loop's thread. Hundreds come at once when a room has moved."""

    def __init__(self) -> None:
        self._under_way: dict[str, asyncio.Task[T]] = {}

    async def look(self, key: str, look: Callable[[], Coroutine[Any, Any, T]]) -> T:
        """What `look` finds, or the look of this key that is under way; raises what it raises.

        It goes on when one of those who wait for it leaves.
        """
        task = self._under_way.get(key)
        if task is None:
            task = self._under_way[key] = asyncio.create_task(look(), name=key)
            task.add_done_callback(functools.partial(self._done, key))
        return await asyncio.shield(task)

    def _done(self, key: str, task: "asyncio.Task[T]") -> None:
        del self._under_way[key]
        if not task.cancelled():
            task.exception()  # whoever asked has heard of it, or has left
