"""The boards that the server knows by name or digest: all presets, and the registered boards."""

from collections import OrderedDict
from typing import Final

from plinko.app.errors import UnknownBoardError
from plinko.engine import Board, preset_names
from plinko.engine.board.payouts import NAMES
from plinko.engine.errors import shorten

MOST_SURFACES: Final = 50_000
"""Pegs and walls of all registered boards: some 6 MB."""


MAX_BOARDS: Final = 256  # registered boards; if there are more, the longest unused is dropped


class Boards:
    """Finds presets by name, and presets and registered boards by digest.

    Registering a board twice is harmless: its address is its digest. If the registered boards are
    too many, or have too many pegs and walls, the longest unused one is dropped; a client can
    register it again. For the event loop's thread only.
    """

    def __init__(self, max_boards: int) -> None:
        self.max_boards = max_boards
        self._registered: OrderedDict[str, Board] = OrderedDict()
        self._surfaces = 0

    def registered(self) -> list[Board]:
        """The registered boards, the longest unused first."""
        return list(self._registered.values())

    def find(self, name: str) -> Board:
        """The board with this preset name or digest; raises UnknownBoardError."""
        preset = name if name in preset_names() else NAMES.get(name)
        if preset is not None:
            return Board.preset(preset)
        if name in self._registered:
            self._registered.move_to_end(name)
            return self._registered[name]
        raise UnknownBoardError(
            f"board {shorten(name)} is neither a preset nor the digest of a registered board",
            field="board",
        )

    def register(self, board: Board) -> bool:
        """Keep a board; returns False if it was known already."""
        if board.digest in NAMES:
            return False
        if board.digest in self._registered:
            self._registered.move_to_end(board.digest)
            return False
        self._registered[board.digest] = board
        self._surfaces += _surfaces_of(board)
        while self._too_many:
            self._surfaces -= _surfaces_of(self._registered.popitem(last=False)[1])
        return True

    @property
    def _too_many(self) -> bool:
        count = len(self._registered)
        return count > self.max_boards or (self._surfaces > MOST_SURFACES and count > 1)


def _surfaces_of(board: Board) -> int:
    return len(board.pegs) + len(board.walls)
