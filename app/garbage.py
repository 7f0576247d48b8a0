"""The garbage collector, kept out of the way of the ticker.

An automatic collection starts wherever the threshold is passed, mostly in the middle of a tick. So
while the ticker runs collection is done by hand, right after a broadcast has left, when there are
some 15 ms until anything is due; while it sleeps the collector runs by itself as usual.
"""

import gc

YOUNG = 2000
"""New objects after which a collection is worth its while; it then takes some 0.1 ms."""

ROUNDS = 10
"""Young collections after which the middle generation is collected too, as Python's default."""

FULL = 3600
"""Ticks after which everything is collected, some 10 ms for hundreds of clients: once a minute."""


class GarbageKeeper:
    """Collects between ticks; a watcher of the ticker."""

    def __init__(self) -> None:
        self.collections = 0
        self._rounds = 0
        self._ticks = 0

    def woke(self) -> None:
        """The ticker runs: no collection by itself from here on."""
        gc.disable()

    def ticked(self, late: float, duration: float) -> None:
        """A tick is over and its frames have left."""
        self._ticks += 1
        if self._ticks % FULL == 0:
            gc.collect()
        elif gc.get_count()[0] >= YOUNG:
            self._rounds += 1
            gc.collect(1 if self._rounds % ROUNDS == 0 else 0)
        else:
            return
        self.collections += 1

    def slept(self) -> None:
        """The ticker sleeps: the collector is on its own again."""
        gc.enable()
