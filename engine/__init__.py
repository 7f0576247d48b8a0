"""The physics of a Plinko board: exact, seeded, replayable bit for bit."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from engine.board.model import Board
from engine.board.presets import preset_names
from engine.constants import PHYSICS_VERSION
from engine.drops.batch import DropBatch, drop_many
from engine.drops.drop import Drop, drop
from engine.drops.occupancy import Occupancy, occupancy
from engine.drops.verify import Verification, verify
from engine.errors import BoardError, EngineError, ParameterError, RecordError, SeedError

if TYPE_CHECKING:
    from engine.certified.certify import Certificate, certify
    from engine.multibody.arena import Arena
    from engine.multibody.settings import ArenaSettings
    from engine.multibody.static_geometry import Place
    from engine.world.world import World

__version__ = "0.1.0"
"""The release. What drops compute has a version of its own, PHYSICS_VERSION."""

__all__ = [
    "PHYSICS_VERSION",
    "Arena",
    "ArenaSettings",
    "Board",
    "BoardError",
    "Certificate",
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
    "__version__",
    "certify",
    "drop",
    "drop_many",
    "occupancy",
    "preset_names",
    "verify",
]

_WHEN_ASKED_FOR: Final = {
    "Arena": "engine.multibody.arena",
    "ArenaSettings": "engine.multibody.settings",
    "Certificate": "engine.certified.certify",
    "Place": "engine.multibody.static_geometry",
    "World": "engine.world.world",
    "certify": "engine.certified.certify",
}
"""Names that a drop has no use for: their kernels take a twentieth of its start to load, and
`certify` needs python-flint, which may not be installed."""


if not TYPE_CHECKING:  # else every misspelt name would pass for one

    def __getattr__(name: str) -> Any:
        if name not in _WHEN_ASKED_FOR:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_WHEN_ASKED_FOR[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
