"""The kinds of rooms there are, and how one of a kind is made."""

from dataclasses import dataclass
from typing import Any

import msgspec

from app.rooms.independent import MODE, Room
from app.rooms.touching.room import INTERACTING, SCENE, ArenaRoom
from app.rooms.touching.scene import Scene
from engine import Board

AnyRoom = Room | ArenaRoom
Ground = Board | Scene

MODES = (MODE, INTERACTING)  # of rooms with boards


@dataclass(frozen=True, slots=True)
class BallLimits:
    """How many balls a room may hold: on their own, or touching each other, which costs more."""

    alone: int
    touching: int


def make_room(
    room_id: str, ground: Ground, mode: str, *, tick_rate: int, limits: BallLimits
) -> AnyRoom:
    """A room as it begins; `mode` is one of MODES, or SCENE for a ground without a board."""
    if mode == MODE:
        assert isinstance(ground, Board)
        return Room(room_id, ground, tick_rate=tick_rate, max_balls=limits.alone)
    return ArenaRoom(room_id, ground, tick_rate=tick_rate, max_balls=limits.touching)


def ground_of(mode: str, text: str) -> Ground:
    """The ground that the ledger keeps as JSON."""
    values: Any = msgspec.json.decode(text)
    return Scene(values) if mode == SCENE else Board.from_json(values)


__all__ = [
    "INTERACTING", "MODE", "MODES", "SCENE", "AnyRoom", "ArenaRoom", "BallLimits", "Ground", "Room",
    "Scene", "ground_of", "make_room",
]  # fmt: skip
