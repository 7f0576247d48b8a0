"""The machine code of flows is up to date with its own kernels and with the engine's."""

import pytest

from benchmarks.billiards import make
from engine.jit import machine_code, stamp


def test_the_artifact_was_made_from_the_present_kernels() -> None:
    made_from = stamp.read(make.ARTIFACT.read_bytes())
    fresh = stamp.current_beside(make.KERNELS)
    assert stamp.is_of(fresh, made_from), "kernels have changed since: `make kernels`"
    name, arrays = "benchmarks.billiards.flow_many.flow_many", "engine.exact.surfaces.lay_out"
    assert set(machine_code.modules_beside(make.KERNELS)) == {name, arrays}


def test_a_change_of_an_engine_kernel_makes_it_stale() -> None:
    files = [make.KERNELS, *stamp.sources()]
    assert stamp.stamp_of_files(files) == stamp.current_beside(make.KERNELS)
    assert any(path.name == "circle_impact.py" for path in files)


@pytest.mark.long("numba compiles for a while")
def test_a_rebuilt_artifact_is_the_committed_one() -> None:
    assert make.made() == make.ARTIFACT.read_bytes()
