"""Distributes work among threads, in a way that an interrupt can end."""

import os
from _thread import LockType, allocate_lock, start_new_thread
from collections import deque
from collections.abc import Callable, Sequence
from typing import TypeVar

from plinko.engine.errors import ParameterError

P = TypeVar("P")


def thread_count(threads: object) -> int:
    """Return `threads`, or for None the number of cores that this process may use.

    Raises ParameterError unless it is from 1 to 1024.
    """
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
    """Call work(part, worker) for all `parts` on `threads` threads; the caller is worker 0.

    Each thread takes the next part until none is left. `work` returns how much it has done;
    `progress` is called on the calling thread with the sum, now and then and at the end. If either
    raises, or at an interrupt, threads finish their current parts and begin no others. Then the
    exception is raised.

    This does not use `threading` or `concurrent.futures`. Their locks are partly written in Python:
    an interrupt right after one was acquired would leave it locked, and all threads would wait for
    ever.
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
