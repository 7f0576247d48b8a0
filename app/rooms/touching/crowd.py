"""Whether a ball may be put where others are. Pure.

Balls that overlap are pushed apart, each pair again and again in a step. Hundreds in one place are
more than a step may take, and no play: a room of them would have to be closed.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from app.errors import BallLimitError
from app.rooms.touching import inputs
from app.rooms.touching.scene import Scene
from engine import Board

MOST_OVERLAPS: Final = 32
"""Balls that one may overlap as it is put in."""


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a ball is, or will be put; m."""

    x: float
    y: float
    radius: float


def spot_of(asked: inputs.TouchingInput, ground: Board | Scene) -> Spot | None:
    """Where an input will put a ball, if it puts one in."""
    if isinstance(asked, inputs.Add):
        return Spot(asked.x, asked.y, asked.radius)
    if isinstance(asked, inputs.Drop) and isinstance(ground, Board):
        return Spot(asked.start(ground), ground.drop.y, ground.ball.radius)
    return None


def check_room(spot: Spot, bodies: npt.NDArray[np.void], coming: Iterable[Spot]) -> None:
    """Raise BallLimitError where a ball would overlap too many, those to come among them."""
    reach = bodies["radius"] + spot.radius
    across, down = bodies["x"] - spot.x, bodies["y"] - spot.y
    overlaps = int((across * across + down * down < reach * reach).sum())
    overlaps += sum(_overlap(spot, other) for other in coming)
    if overlaps > MOST_OVERLAPS:
        raise BallLimitError(
            f"{overlaps} balls are at ({spot.x:g}, {spot.y:g}) m already, and a ball may be put "
            f"into {MOST_OVERLAPS} at most: choose another place, or wait until they have gone",
            field="x",
        )


def _overlap(one: Spot, other: Spot) -> bool:
    across, down, reach = one.x - other.x, one.y - other.y, one.radius + other.radius
    return across * across + down * down < reach * reach
