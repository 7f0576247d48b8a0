"""Work shared among threads; an interrupt ends it."""

import os
from _thread import LockType, allocate_lock, start_new_thread
from collections import deque
from collections.abc import Callable, Sequence
from typing import TypeVar

from engine.errors import ParameterError

P = TypeVar("P")


def thread_count(threads: object) -> int:
    """`threads`, by default the cores this process may use; ParameterError for no such number."""
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if isinstance(threads, bool) or not isinstance(threads, int) or not 1 <= threads <= 1024:
        raise ParameterError(
            f"threads {threads!r} is not a whole number from 1 to 1024", field="threads"
        )
    return threads


def share(
    parts: Sequence[P],
    work: Callable[[P, int], int],
    threads: int,
    progress: Callable[[int], None] | None = None,
) -> None:
    """Call work(part, worker) for all `parts` on so many threads, of which the calling one is 0.

    Each takes the next part that is left. `work` returns how much it has done; `progress` is called
    on the calling thread with the sum, now and then, and at the end. What either raises, or an
    interrupt, ends it: parts that were begun are finished, the others are not begun.

    Without `threading` and `concurrent.futures`: their locks are written in Python, and where an
    interrupt comes just after one was taken, it stays so, and all wait for ever.
    """
    todo = deque(parts)
    done: list[int] = []
    failures: list[Exception] = []

    def help_out(worker: int, ended: LockType) -> None:
        try:
            while (part := _take(todo)) is not None:
                done.append(work(part, worker))
        except Exception as error:  # noqa: BLE001 - raised again by the thread that called
            failures.append(error)
            todo.clear()
        finally:
            ended.release()

    helpers: list[LockType] = []
    reported = 0
    try:
        for worker in range(1, min(threads, len(parts))):
            ended = allocate_lock()
            ended.acquire()
            start_new_thread(help_out, (worker, ended))
            helpers.append(ended)
        while (part := _take(todo)) is not None:
            done.append(work(part, 0))
            if progress:
                reported = sum(done)
                progress(reported)
    finally:
        todo.clear()
        for ended in helpers:
            ended.acquire()
    if failures:
        raise failures[0]
    if progress and reported != sum(done):
        progress(sum(done))


def _take(todo: deque[P]) -> P | None:
    try:
        return todo.popleft()
    except IndexError:
        return None
