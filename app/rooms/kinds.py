"""The table of all kinds of rooms, and the functions that make rooms from it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import msgspec

from plinko.app.rooms.draw import Draw
from plinko.app.rooms.independent import DRAW, INDEPENDENT, DrawRoom, IndependentRoom
from plinko.app.rooms.input_format import AnyFormat
from plinko.app.rooms.room import Basis, Ground, Room
from plinko.app.rooms.touching.room import INTERACTING, SCENE, TouchingRoom
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import Board
from plinko.engine.json_text import JsonObject

MODES: Final = (INDEPENDENT, INTERACTING)  # of rooms with a board and without a draw


MAX_TOUCHING = 500  # balls in one room whose balls touch each other


@dataclass(frozen=True, slots=True)
class BallLimits:
    """The most balls in a room: of independent balls (`alone`), or of touching ones."""

    alone: int
    touching: int


NO_LIMIT: Final = BallLimits(1 << 62, 1 << 62)
"""For a replay, which takes every ball that its room took."""


@dataclass(frozen=True, slots=True)
class _Kind:
    """How to make a room of one mode."""

    room: Callable[..., Room]
    format: AnyFormat
    ground: Callable[[JsonObject], Ground]  # from JSON
    touching: bool = False


_KINDS: Final = {
    INDEPENDENT: _Kind(IndependentRoom, IndependentRoom.format, Board.kept),
    DRAW: _Kind(DrawRoom, DrawRoom.format, Board.kept),
    INTERACTING: _Kind(TouchingRoom, TouchingRoom.format, Board.kept, touching=True),
    SCENE: _Kind(TouchingRoom, TouchingRoom.format, Scene, touching=True),
}


def make_room(room_id: str, basis: Basis, mode: str, *, tick_rate: int, limits: BallLimits) -> Room:
    """A new room at tick 0.

    `mode` is one of MODES, DRAW if `basis` is a draw, or SCENE if it is a scene.
    """
    kind = _KINDS[mode]
    most = limits.touching if kind.touching else limits.alone
    return kind.room(room_id, basis, tick_rate=tick_rate, max_balls=most)


def format_of(mode: str) -> AnyFormat:
    """How the ledger and the log write the inputs of rooms of this mode."""
    return _KINDS[mode].format


def ground_of(mode: str, text: str) -> Ground:
    """The board or scene in the ledger's JSON."""
    return _KINDS[mode].ground(msgspec.json.decode(text))


def draw_of(ground: Ground, text: str) -> Draw:
    """The draw in the ledger's JSON; raises InvalidValueError if it belongs to another board."""
    assert isinstance(ground, Board)
    return Draw.of_values(ground, msgspec.json.decode(text))


__all__ = [
    "DRAW", "INDEPENDENT", "INTERACTING", "MODES", "NO_LIMIT", "SCENE", "BallLimits", "draw_of",
    "format_of", "ground_of", "make_room",
]  # fmt: skip
