"""Compiles flow_many.py to flow_many.wasm: python -m benchmarks.billiards.make"""

from pathlib import Path
from typing import Final

from benchmarks.billiards import flow_many
from benchmarks.billiards.billiard import Billiard
from benchmarks.billiards.flow import launch
from plinko.engine.artifact.make import made_by

KERNELS: Final = Path(flow_many.__file__)
ARTIFACT: Final = KERNELS.with_suffix(".wasm")


def sample_calls() -> None:
    """Call once each kernel that Python calls, so that its argument types are known."""
    launch(Billiard(gravity=1.0), [(0.0, 0.5)], [(1.0, 0.0)], tangents=True).until(0.1)


def made() -> bytes:
    """Compile the artifact and return its bytes."""
    return made_by(
        "from benchmarks.billiards.make import KERNELS, sample_calls; "
        "from plinko.engine.artifact.record_types import compiled_beside; "
        "made = compiled_beside(KERNELS, sample_calls)"
    )


if __name__ == "__main__":
    ARTIFACT.write_bytes(made())
