"""Memory that was let go: found while there is time, and given back to the system."""

import asyncio
import contextlib
import ctypes
import gc
import math
import time
from collections.abc import Awaitable, Callable
from typing import Final

_EVERY: Final = 2.0
"""s between two times that memory is given back. After 2 s of attacks it takes 1 to 4 ms, in which
nothing is allocated; after 30 s it took 50."""

_TAKES: Final = 0.006  # s before a tick, in which it is not begun any more
_AFTER: Final = 0.002  # s after that tick was due, when it is

_COLLECTS: Final = 10.0  # s between two full collections, if they find a moment
_PATIENCE: Final = 3  # times as long without one, and it comes whatever it delays
_SHORT: Final = 0.005  # s of a tick after which there is time for one before the next: some 10 ms

_SELDOM: Final = 100
"""Collections of younger objects, ten times what Python has, after which it makes a full one by
itself. Where something moves, `Collector` makes it before that."""


_ARENA_MAX: Final = -8  # M_ARENA_MAX of glibc's malloc.h


def share_one_heap() -> None:
    """Have all threads allocate from one heap; to be called before there are any.

    glibc gives each thread a heap of its own, up to eight for a core, and what is free in one of
    them is of no use to the others: after three rounds of all of `plinko bench attack` a server
    had 155 MB like that, and has 15 now. Threads of Python hardly ever allocate at once.
    """
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).mallopt(_ARENA_MAX, 1)


def give_back() -> None:
    """Let the system have what is not in use: compilers leave a tenth of all."""
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)


async def give_back_regularly(
    done: Callable[[], object],
    due_in: Callable[[], float] = lambda: math.inf,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
) -> None:
    """`give_back` now and then, where what is `done` so far has changed, until cancelled.

    Not before a tick, which would have to wait for it: `due_in` says in how many s one is due.
    glibc by itself keeps what lies between pieces in use. To have large pieces go back as they are
    let go (M_MMAP_THRESHOLD) makes threads wait for each other: of the ticks of `main` amid all of
    `plinko bench attack`, 92 to 95 % came within 4 ms then, instead of 96 to 97.
    """
    before = None
    while True:
        await sleep(_EVERY)
        now = done()
        if now != before:
            if (due := due_in()) < _TAKES:
                await sleep(due + _AFTER)
            await asyncio.to_thread(give_back)
        before = now


def settle() -> None:
    """Leave what lives for good out of all later garbage collections, and make few full ones.

    A full collection walks every live object, all libraries' included, and holds up the ticker for
    some 50 ms; frozen objects are not walked.
    """
    gc.collect()
    gc.freeze()
    young, middle, _ = gc.get_threshold()
    gc.set_threshold(young, middle, _SELDOM)


class Collector:
    """Full garbage collections just after a tick, when there is time for one; watches the ticker.

    Python makes them at any moment: 4 to 10 ms amid an attack, when a tick may be due.
    """

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, collect: Callable[[], int] = gc.collect
    ) -> None:
        self._clock = clock
        self._collect = collect
        self._last = clock()

    def woke(self) -> None:
        """Nothing."""

    def ticked(self, late: float, duration: float) -> None:
        """There is time now until the next tick, the more the shorter this one was."""
        waited = self._clock() - self._last
        if waited > (_COLLECTS if late + duration < _SHORT else _PATIENCE * _COLLECTS):
            self._collect()
            self._last = self._clock()

    def slept(self) -> None:
        """Nothing: no tick waits for what Python does by itself."""
