"""Lets boards with short falls take stakes: on a preset, each drop takes seconds."""

import pytest

from plinko.engine import Board
from plinko.engine.payouts.listing import takes_stakes

NAMES = ("tiny", "quick")


def taken(board: Board) -> bool:
    """Whether drops on this board may have a stake during tests."""
    return board.name in NAMES or takes_stakes(board)


def begin() -> None:
    """Change it for this whole process."""
    pytest.MonkeyPatch().setattr("plinko.app.rooms.independent.takes_stakes", taken)
