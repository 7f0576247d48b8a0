"""The world of a room of touching balls: an arena, the hands that hold balls, and a clock. Pure.

In each tick of the server the arena takes as many steps as fit its dt. A snapshot contains the
whole state, so a restored world continues bit for bit.
"""

import copy
import hashlib
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.protocol.messages import Extent
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import Board
from plinko.engine.errors import RecordError
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.scenes import on_board
from plinko.engine.multibody.static_geometry import StaticGeometry

HOLD_RATE: Final = 12.0
"""1/s; the rate at which a grabbed ball closes the gap to the hand: firm, yet no faster than a hand
moves."""

HOLD_SPEED: Final = 15.0  # m/s; the fastest that a hand pulls, and so throws, a ball

HOLD_LAPSE: Final = 5.0  # s after its last message a hand releases its ball


@dataclass(frozen=True, slots=True)
class Box:
    """A scene's pegs and walls, and its default radius of a ball, in m."""

    place: StaticGeometry
    radius: float


class _Saved(msgspec.Struct, frozen=True):
    tick: int
    arena: bytes
    holds: list[tuple[int, float, float, int]] = msgspec.field(name="grips")


class TouchingWorld:
    """The arena of a board or scene, with a clock of `tick_rate` ticks a second."""

    def __init__(self, ground: Board | Scene, tick_rate: int) -> None:
        self.tick_rate = tick_rate
        self.tick = 0
        self.arena: Arena = ground.build() if isinstance(ground, Scene) else on_board(ground)
        # By ball: the hand's x and y in m, and the tick at which it releases the ball.
        self.holds: dict[int, tuple[float, float, int]] = {}

    @property
    def awake(self) -> bool:
        """Whether any ball moves, or a hand holds one and may move it."""
        return bool(self.holds) or self.arena.awake

    @property
    def count(self) -> int:
        return self.arena.count

    @property
    def extent(self) -> Extent:
        """The bounding box of the walls and pegs."""
        return Extent(*self.place.extent)

    @property
    def place(self) -> StaticGeometry:
        return self.arena.place

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        return self.arena.bodies

    def has(self, ball: int) -> bool:
        return bool((self.arena.bodies["id"] == ball).any())

    def hold(self, ball: int, x: float, y: float) -> None:
        self.holds[ball] = (x, y, self.tick + round(HOLD_LAPSE * self.tick_rate))

    def release(self, ball: int) -> None:
        self.holds.pop(ball, None)

    def step(self) -> None:
        if self.holds:
            self._pull()
        self.arena.advance(1.0 / self.tick_rate)
        self.tick += 1

    def _pull(self) -> None:
        rows = {int(row["id"]): row for row in self.arena.bodies}
        for ball, (x, y, lapse) in sorted(self.holds.items()):
            row = rows.get(ball)
            if row is None or self.tick >= lapse:
                del self.holds[ball]
                continue
            vx, vy = HOLD_RATE * (x - float(row["x"])), HOLD_RATE * (y - float(row["y"]))
            speed = float(np.sqrt(vx * vx + vy * vy))
            if speed > HOLD_SPEED:
                vx, vy = vx * (HOLD_SPEED / speed), vy * (HOLD_SPEED / speed)
            self.arena.kick(ball, vx - float(row["vx"]), vy - float(row["vy"]))

    def copy(self) -> "TouchingWorld":
        """An independent copy, which continues bit for bit."""
        other = copy.copy(self)
        other.arena, other.holds = self.arena.copy(), self.holds.copy()
        return other

    def become(self, other: "TouchingWorld") -> None:
        """Take over the state of `other`, which must not be used any more."""
        self.tick, self.arena, self.holds = other.tick, other.arena, other.holds

    def snapshot(self) -> bytes:
        holds = [(ball, x, y, lapse) for ball, (x, y, lapse) in sorted(self.holds.items())]
        return msgspec.msgpack.encode(_Saved(self.tick, self.arena.snapshot(), holds))

    def restore(self, snapshot: bytes) -> None:
        """Take over the state in `snapshot`; raises RecordError if it is unreadable."""
        try:
            saved = msgspec.msgpack.decode(snapshot, type=_Saved)
        except msgspec.MsgspecError as error:
            raise RecordError(f"the snapshot is unreadable: {error}", field="snapshot") from error
        self.arena = Arena.from_snapshot(saved.arena)
        self.tick = saved.tick
        self.holds = {ball: (x, y, lapse) for ball, x, y, lapse in saved.holds}

    @property
    def digest(self) -> str:
        """SHA-256 of the world, 64 hex digits: equal worlds have equal digests."""
        rest: list[object] = [self.tick, sorted(self.holds.items())]
        packed = msgspec.msgpack.encode(rest)
        return hashlib.sha256(self.arena.digest.encode() + packed).hexdigest()


class NextTick:
    """The next tick of a world, computed on another thread from a copy.

    Only the event loop's thread reads or changes a room's world. The computing thread has a private
    copy. When the tick begins, the room takes the finished copy in place of its own world. If an
    input is carried out before that, the copy no longer fits, and the room discards it. A tick
    therefore has the same bits on whichever thread it ran, and no code waits for a world or sees
    one half computed.
    """

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
