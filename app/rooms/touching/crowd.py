"""Refuses a ball that would overlap too many others. Pure.

The solver pushes overlapping balls apart, each pair several times in a step. With hundreds of balls
in one place a step would take too long, and the room would have to be closed.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from plinko.app.errors import BallLimitError
from plinko.app.rooms.touching import inputs
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import Board

MOST_OVERLAPS: Final = 32
"""Balls that an added ball may overlap."""


@dataclass(frozen=True, slots=True)
class Spot:
    """The place of a ball that exists or will be added, in m."""

    x: float
    y: float
    radius: float


def spot_of(asked: inputs.TouchingInput, ground: Board | Scene) -> Spot | None:
    """Where an input will add a ball; None if it adds none."""
    if isinstance(asked, inputs.Add):
        return Spot(asked.x, asked.y, asked.radius)
    if isinstance(asked, inputs.Drop) and isinstance(ground, Board):
        return Spot(asked.start(ground), ground.drop.y, ground.ball.radius)
    return None


def check_room(spot: Spot, bodies: npt.NDArray[np.void], coming: Iterable[Spot]) -> None:
    """Raise BallLimitError if a ball would overlap too many of `bodies` and `coming`."""
    reach = bodies["radius"] + spot.radius
    across, down = bodies["x"] - spot.x, bodies["y"] - spot.y
    overlaps = int((across * across + down * down < reach * reach).sum())
    overlaps += sum(_overlap(spot, other) for other in coming)
    if overlaps > MOST_OVERLAPS:
        raise BallLimitError(
            f"{overlaps} balls are at ({spot.x:g}, {spot.y:g}) m already, and a new ball may "
            f"overlap at most {MOST_OVERLAPS}: choose another place, or wait until they have gone",
            field="x",
        )


def _overlap(one: Spot, other: Spot) -> bool:
    across, down, reach = one.x - other.x, one.y - other.y, one.radius + other.radius
    return across * across + down * down < reach * reach
