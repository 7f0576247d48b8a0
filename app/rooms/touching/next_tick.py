"""The next tick of a room whose balls touch each other, computed beside the room.

Who owns what is decided here alone. A room's world belongs to the thread of the event loop, always:
it is read, shown, saved and changed there. Whoever computes the next tick has a copy that nobody
else knows, and is done with it when the room takes it in place of its own, at that tick's begin. An
input that is carried out before makes the copy worthless: the room drops it. So a tick has the same
bits wherever it was computed, and nobody ever waits for a world or finds it half done.
"""

from app.rooms.touching.world import TouchingWorld


class NextTick:
    """A copy of a world, to be one tick on."""

    def __init__(self, world: TouchingWorld) -> None:
        self.done = False
        self._world = world.copy()
        self._error: Exception | None = None

    def compute(self) -> None:
        """Step it; for any one thread. What is raised is for who takes it."""
        try:
            self._world.step()
        except Exception as error:  # noqa: BLE001 - the room fails with it, in its own turn
            self._error = error
        self.done = True

    def take(self) -> TouchingWorld:
        """The world one tick on, once it is done; raises what the step raised."""
        if self._error is not None:
            raise self._error
        return self._world
