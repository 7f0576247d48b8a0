"""The public rooms, which always exist and have no owner: their names, boards and scenes."""

from collections.abc import Callable
from typing import Final

from plinko.app.errors import UnknownRoomError
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import INDEPENDENT, INTERACTING, SCENE
from plinko.app.rooms.room import Ground
from plinko.app.rooms.touching.scene import GALTON, SANDBOX, Scene
from plinko.engine import Board, preset_names
from plinko.engine.errors import shorten

MAIN: Final = "main"
"""The room whose ticks run first."""

PUBLIC_SCENES: Final = {"sandbox": SANDBOX, "galton-pile": GALTON}
"""Scenes of public rooms, by room id."""

_TOUCHING: Final = "interacting-"
"""With a preset's name after it: the room where balls on that board touch."""


class PublicTables:
    """The board or scene of each public room; `scene` makes a scene from its JSON."""

    def __init__(self, boards: Boards, main: Board, scene: Callable[[object], Scene]) -> None:
        self._boards = boards
        self._main = main
        self._scene = scene

    def find(self, room_id: str) -> tuple[Ground, str]:
        """The board or scene of a public room, and its mode; raises UnknownRoomError."""
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
            f"room {shorten(room_id)} is not open, and it is not the name of a preset board",
            field="room",
        )

    def ground(self, room_id: str) -> Ground | None:
        """The board or scene of a public room; None for any other."""
        return self.find(room_id)[0] if room_id in self else None

    def __contains__(self, room_id: str) -> bool:
        """Whether a room with this id is public; any other has an owner."""
        preset = room_id.removeprefix(_TOUCHING)
        return room_id == MAIN or room_id in PUBLIC_SCENES or preset in preset_names()
