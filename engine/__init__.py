"""The physics of a Plinko board: exact, seeded, replayable bit for bit."""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final

# Started in a checkout, Python finds this folder as `engine`: a second copy of every module.
if __name__ != "plinko.engine":
    raise ImportError(f"{__name__} is the source of plinko.engine: import plinko.engine")

from plinko.engine.board.making import polygon
from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Label, Peg, Wall
from plinko.engine.board.presets import preset_names
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.drops.batch import DropBatch, concat, drop_many
from plinko.engine.drops.certainty import Certainty
from plinko.engine.drops.draws import find_draw
from plinko.engine.drops.drop import Drop, drop
from plinko.engine.drops.occupancy import Occupancy, occupancy
from plinko.engine.drops.seeds import seeds_landing_in
from plinko.engine.drops.sweep import sweep
from plinko.engine.drops.trajectory import Trajectory
from plinko.engine.drops.verify import Verification, verify
from plinko.engine.errors import (
    BoardError,
    ClusterError,
    EffortError,
    Fault,
    JsonSyntaxError,
    JsonValueError,
    MissingPartError,
    ParameterError,
    PlinkoError,
    RecordError,
    SeedError,
)
from plinko.engine.parameters import Solver

if TYPE_CHECKING:
    from plinko.engine.certified.certify import Certificate, certify
    from plinko.engine.multibody.arena import Arena
    from plinko.engine.multibody.settings import ArenaSettings
    from plinko.engine.multibody.static_geometry import StaticGeometry
    from plinko.engine.world.world import World

__version__ = "2.0.0"
"""The release. PHYSICS_VERSION is the separate version of the drops' results."""

__all__ = [
    "PHYSICS_VERSION",
    "Arena",
    "ArenaSettings",
    "BallSpec",
    "Bins",
    "Board",
    "BoardError",
    "Certainty",
    "Certificate",
    "ClusterError",
    "Drop",
    "DropBatch",
    "DropZone",
    "EffortError",
    "Fault",
    "JsonSyntaxError",
    "JsonValueError",
    "Label",
    "Material",
    "MissingPartError",
    "Occupancy",
    "ParameterError",
    "Peg",
    "PlinkoError",
    "RecordError",
    "SeedError",
    "Solver",
    "StaticGeometry",
    "Trajectory",
    "Verification",
    "Wall",
    "World",
    "__version__",
    "certify",
    "concat",
    "drop",
    "drop_many",
    "find_draw",
    "occupancy",
    "polygon",
    "preset_names",
    "seeds_landing_in",
    "sweep",
    "verify",
]

_WHEN_ASKED_FOR: Final = {
    "Arena": "plinko.engine.multibody.arena",
    "ArenaSettings": "plinko.engine.multibody.settings",
    "Certificate": "plinko.engine.certified.certify",
    "StaticGeometry": "plinko.engine.multibody.static_geometry",
    "World": "plinko.engine.world.world",
    "certify": "plinko.engine.certified.certify",
}
"""Names that are imported on first use. A drop does not need them, and loading their kernels would
add a twentieth to the start of a program that only drops balls."""

_PROOFS: Final = ("Certificate", "certify")
"""Names that exist only if python-flint is installed."""

if find_spec("flint") is None:
    for _name in _PROOFS:
        __all__.remove(_name)


if not TYPE_CHECKING:  # otherwise type checkers would accept every misspelt name

    def __getattr__(name: str) -> Any:
        if name in _PROOFS and name not in __all__:
            raise AttributeError(
                f"{__name__}.{name} needs python-flint: pip install 'plinko-sim[certify]'"
            )
        if name not in _WHEN_ASKED_FOR:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_WHEN_ASKED_FOR[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
