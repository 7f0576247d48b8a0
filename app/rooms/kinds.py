"""The kinds of rooms there are, and how one of a kind is made."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import msgspec

from app.rooms.draw import Draw
from app.rooms.independent import DRAW, INDEPENDENT, DrawRoom, IndependentRoom
from app.rooms.input_format import AnyFormat
from app.rooms.room import Basis, Ground, Room
from app.rooms.touching.room import INTERACTING, SCENE, TouchingRoom
from app.rooms.touching.scene import Scene
from engine import Board
from engine.json_text import JsonObject

MODES: Final = (INDEPENDENT, INTERACTING)  # of rooms with boards alone


MAX_TOUCHING = 500  # balls in one room whose balls touch each other


@dataclass(frozen=True, slots=True)
class BallLimits:
    """How many balls a room may hold: on their own, or touching each other, which costs more."""

    alone: int
    touching: int


@dataclass(frozen=True, slots=True)
class _Kind:
    """What is to be known of rooms of one mode before there is one."""

    room: Callable[..., Room]
    format: AnyFormat
    ground: Callable[[JsonObject], Ground]  # from JSON
    most_balls: Callable[[BallLimits], int]


def _alone(limits: BallLimits) -> int:
    return limits.alone


def _together(limits: BallLimits) -> int:
    return limits.touching


_KINDS: Final = {
    INDEPENDENT: _Kind(IndependentRoom, IndependentRoom.format, Board.kept, _alone),
    DRAW: _Kind(DrawRoom, DrawRoom.format, Board.kept, _alone),
    INTERACTING: _Kind(TouchingRoom, TouchingRoom.format, Board.kept, _together),
    SCENE: _Kind(TouchingRoom, TouchingRoom.format, Scene, _together),
}


def make_room(room_id: str, basis: Basis, mode: str, *, tick_rate: int, limits: BallLimits) -> Room:
    """A room as it begins.

    `mode` is one of MODES, DRAW for a draw, or SCENE for a ground without a board.
    """
    kind = _KINDS[mode]
    return kind.room(room_id, basis, tick_rate=tick_rate, max_balls=kind.most_balls(limits))


def format_of(mode: str) -> AnyFormat:
    """How the inputs of rooms of this mode are kept and logged."""
    return _KINDS[mode].format


def ground_of(mode: str, text: str) -> Ground:
    """The ground that the ledger keeps as JSON."""
    return _KINDS[mode].ground(msgspec.json.decode(text))


def draw_of(ground: Ground, text: str) -> Draw:
    """The draw over a board that the ledger keeps as JSON; raises InvalidValueError for another."""
    assert isinstance(ground, Board)
    return Draw.of_values(ground, msgspec.json.decode(text))


__all__ = [
    "DRAW", "INDEPENDENT", "INTERACTING", "MODES", "SCENE", "BallLimits", "draw_of", "format_of",
    "ground_of", "make_room",
]  # fmt: skip
