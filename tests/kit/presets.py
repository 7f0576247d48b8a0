"""Presets for tests that look at many: all of the house table, and one of each world."""

from typing import Final

from plinko.engine.board.presets import HOUSE_NAMES
from plinko.engine.board.worlds import WORLDS

SAMPLE: Final = (*HOUSE_NAMES, *(f"{world}-16" for world in WORLDS))
