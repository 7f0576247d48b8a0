"""The rooms that are always there and belong to nobody: which names they have, and what over."""

from collections.abc import Callable
from typing import Final

from app.errors import UnknownRoomError, shorten
from app.rooms.boards import Boards
from app.rooms.kinds import INDEPENDENT, INTERACTING, SCENE
from app.rooms.room import Ground
from app.rooms.touching.scene import GALTON, SANDBOX, Scene
from engine import Board, preset_names

MAIN: Final = "main"
"""The room that has its turn first."""

PUBLIC_SCENES: Final = {"sandbox": SANDBOX, "galton-pile": GALTON}
"""Rooms of scenes, by id."""

_TOUCHING: Final = "interacting-"
"""Before a preset's name: the table on which balls knock each other."""


class PublicTables:
    """What is to be played at under each public name; `scene` makes one of its JSON object."""

    def __init__(self, boards: Boards, main: Board, scene: Callable[[object], Scene]) -> None:
        self._boards = boards
        self._main = main
        self._scene = scene

    def find(self, room_id: str) -> tuple[Ground, str]:
        """What the room of this name is over, and its mode; raises UnknownRoomError."""
        if room_id == MAIN:
            return self._main, INDEPENDENT
        if room_id in preset_names():
            return self._boards.find(room_id), INDEPENDENT
        if room_id in PUBLIC_SCENES:
            return self._scene({"scene": PUBLIC_SCENES[room_id]}), SCENE
        preset = room_id.removeprefix(_TOUCHING)
        if preset != room_id and preset in preset_names():
            return self._boards.find(preset), INTERACTING
        raise UnknownRoomError(
            f"room {shorten(room_id)} is neither open nor the name of a preset board", field="room"
        )

    def ground(self, room_id: str) -> Ground | None:
        """What the room of this name is over; None for any other."""
        return self.find(room_id)[0] if room_id in self else None

    def __contains__(self, room_id: str) -> bool:
        """Whether a room of this id is everybody's; any other is a player's own."""
        preset = room_id.removeprefix(_TOUCHING)
        return room_id == MAIN or room_id in PUBLIC_SCENES or preset in preset_names()
