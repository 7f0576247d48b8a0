"""The next tick of a room of touching balls, computed on another thread from a copy of its world.

Ownership: only the event loop's thread reads or changes a room's world. The computing thread has a
private copy. When the tick begins, the room takes the finished copy in place of its own world. If
an input is carried out before that, the copy no longer fits, and the room discards it. A tick
therefore has the same bits on whichever thread it ran, and no code waits for a world or sees one
half computed.
"""

from plinko.app.rooms.touching.world import TouchingWorld


class NextTick:
    """A copy of a world, to be advanced by one tick."""

    def __init__(self, world: TouchingWorld) -> None:
        self.done = False
        self._world = world.copy()
        self._error: Exception | None = None

    def compute(self) -> None:
        """Advance the copy, on any thread; `take` raises an exception of the step."""
        try:
            self._world.step()
        except Exception as error:  # noqa: BLE001 - `take` raises it where the room can fail
            self._error = error
        self.done = True

    def take(self) -> TouchingWorld:
        """The advanced world, once `done`; raises the exception of the step, if any."""
        if self._error is not None:
            raise self._error
        return self._world
