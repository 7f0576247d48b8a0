"""The machine code of flows is up to date with its own kernels and with the engine's."""

import pytest

from benchmarks.billiards import make
from plinko.engine.jit import machine_code, source_hash


def test_the_artifact_was_made_from_the_present_kernels() -> None:
    made_from = source_hash.read(make.ARTIFACT.read_bytes())
    fresh = source_hash.current_beside(make.KERNELS)
    assert source_hash.is_of(fresh, made_from), "kernels have changed since: `make kernels`"
    name = "benchmarks.billiards.flow_many.flow_many"
    assert set(machine_code.modules_beside(make.KERNELS)) == {name}


def test_a_change_of_an_engine_kernel_makes_it_stale() -> None:
    files = [make.KERNELS, *source_hash.sources()]
    assert source_hash.hash_of_files(files) == source_hash.current_beside(make.KERNELS)
    assert any(path.name == "circle_impact.py" for path in files)


@pytest.mark.long("numba compiles for a while")
def test_a_rebuilt_artifact_is_the_committed_one() -> None:
    assert make.made() == make.ARTIFACT.read_bytes()
