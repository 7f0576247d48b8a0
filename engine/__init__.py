"""The physics of a Plinko board: exact, seeded, replayable bit for bit."""

from engine.arena import Arena
from engine.arena_settings import ArenaSettings
from engine.batch import DropBatch, drop_many
from engine.board import Board
from engine.constants import PHYSICS_VERSION
from engine.drop import Drop, drop
from engine.errors import BoardError, EngineError, ParameterError, RecordError, SeedError
from engine.occupancy import Occupancy, occupancy
from engine.place import Place
from engine.presets import preset_names
from engine.verify import Verification, verify
from engine.world import World

__all__ = [
    "PHYSICS_VERSION",
    "Arena",
    "ArenaSettings",
    "Board",
    "BoardError",
    "Drop",
    "DropBatch",
    "EngineError",
    "Occupancy",
    "ParameterError",
    "Place",
    "RecordError",
    "SeedError",
    "Verification",
    "World",
    "drop",
    "drop_many",
    "occupancy",
    "preset_names",
    "verify",
]
