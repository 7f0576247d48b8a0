"""Compiles flow_many.py to flow_many.wasm: python -m benchmarks.billiards.make"""

from pathlib import Path
from typing import Final

from benchmarks.billiards import flow_many
from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow import launch
from engine.artifact.make import made_by

KERNELS: Final = Path(flow_many.__file__)
ARTIFACT: Final = KERNELS.with_suffix(".wasm")


def play() -> None:
    """Call once each kernel that Python calls, so that its argument types are known."""
    launch(Billiard(gravity=1.0), [(0.0, 0.5)], [(1.0, 0.0)], tangents=True).until(0.1)


def made() -> bytes:
    """Compile the artifact and return its bytes."""
    return made_by(
        "from benchmarks.billiards.make import KERNELS, play; "
        "from engine.artifact.rehearsal import compiled_beside; "
        "made = compiled_beside(KERNELS, play)"
    )


if __name__ == "__main__":
    ARTIFACT.write_bytes(made())
