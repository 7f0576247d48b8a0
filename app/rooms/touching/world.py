"""What a room of balls that touch each other ticks: an arena, the hands that hold balls, its clock.

Pure. A tick is a frame of the server's rate; the arena takes as many of its own steps in it as its
dt says. All of it goes into `snapshot`, so that a restored world goes on bit for bit.
"""

import copy
import hashlib
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from app.protocol.messages import Extent
from app.rooms.touching.scene import Scene
from engine import Board
from engine.errors import RecordError
from engine.multibody.arena import Arena
from engine.multibody.scenes import on_board
from engine.multibody.static_geometry import Place

HOLD_RATE: Final = 12.0
"""1/s; a held ball closes the gap to the hand at this rate: firm, and no faster than a hand is."""

HOLD_SPEED: Final = 15.0  # m/s; the fastest a hand draws a ball, so also the fastest such throw

HOLD_LAPSE: Final = 5.0  # s; a hand of which nothing is heard any more lets go


@dataclass(frozen=True, slots=True)
class Box:
    """What does not move in a scene, and the radius of a usual ball in it, m."""

    place: Place
    radius: float


class _Saved(msgspec.Struct, frozen=True):
    tick: int
    arena: bytes
    holds: list[tuple[int, float, float, int]] = msgspec.field(name="grips")


class TouchingWorld:
    """An arena under a clock of `tick_rate` ticks a second, begun as `ground` says."""

    def __init__(self, ground: Board | Scene, tick_rate: int) -> None:
        self.tick_rate = tick_rate
        self.tick = 0
        self.arena: Arena = ground.build() if isinstance(ground, Scene) else on_board(ground)
        # Ball to the place of the hand, m, and the tick at which it lets go.
        self.holds: dict[int, tuple[float, float, int]] = {}

    @property
    def awake(self) -> bool:
        """Whether anything moves, or is held and so may have to."""
        return bool(self.holds) or self.arena.awake

    @property
    def count(self) -> int:
        return self.arena.count

    @property
    def extent(self) -> Extent:
        """The box that holds all that does not move."""
        return Extent(*self.place.extent)

    @property
    def place(self) -> Place:
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
        """A world that goes on from here by itself, bit for bit."""
        other = copy.copy(self)
        other.arena, other.holds = self.arena.copy(), self.holds.copy()
        return other

    def become(self, other: "TouchingWorld") -> None:
        """Go on as a copy of this world, which is not used any more."""
        self.tick, self.arena, self.holds = other.tick, other.arena, other.holds

    def snapshot(self) -> bytes:
        holds = [(ball, x, y, lapse) for ball, (x, y, lapse) in sorted(self.holds.items())]
        return msgspec.msgpack.encode(_Saved(self.tick, self.arena.snapshot(), holds))

    def restore(self, snapshot: bytes) -> None:
        """Become the world that made `snapshot`; raises RecordError when it is no such thing."""
        try:
            saved = msgspec.msgpack.decode(snapshot, type=_Saved)
        except msgspec.MsgspecError as error:
            raise RecordError(f"the snapshot is not one: {error}", field="snapshot") from error
        self.arena = Arena.from_snapshot(saved.arena)
        self.tick = saved.tick
        self.holds = {ball: (x, y, lapse) for ball, x, y, lapse in saved.holds}

    def digest(self) -> str:
        """SHA-256 of the world, 64 hex digits: equal worlds have equal digests."""
        rest: list[object] = [self.tick, sorted(self.holds.items())]
        packed = msgspec.msgpack.encode(rest)
        return hashlib.sha256(self.arena.digest().encode() + packed).hexdigest()
