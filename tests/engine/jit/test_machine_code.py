"""Machine code replaces every kernel: it is called in the same way and gives the same bits."""

import importlib
import json
import os
import pkgutil
import threading
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest

from plinko import engine
from plinko.engine import Board, drop, drop_many
from plinko.engine.constants import MAX_TIME
from plinko.engine.errors import EffortError
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.initial_state import at_rest, in_flight
from plinko.engine.exact.sampling import sample
from plinko.engine.exact.trace import trace_many
from plinko.engine.jit import limits, machine_code, native, source_hash
from plinko.engine.jit.decorator import EntryKernel, in_place
from plinko.engine.multibody.scenes import sandbox
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series
from tools.golden import check

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")

Floats = npt.NDArray[np.float64]


def entries() -> dict[str, EntryKernel[Any, Any]]:
    """All kernels that Python calls, by name."""
    names = [each.name for each in pkgutil.walk_packages(engine.__path__, "plinko.engine.")]
    modules = [importlib.import_module(name) for name in names if ".artifact" not in name]
    found = [value for each in modules for value in vars(each).values()]
    return {each.name: each for each in found if isinstance(each, EntryKernel)}


def test_every_kernel_that_python_enters_is_in_an_artifact() -> None:
    kernels = entries()
    assert "plinko.engine.exact.trace.trace_many" in kernels
    in_libraries = json.loads(native.INDEX.read_bytes())["calls"]
    assert set(kernels) == set(machine_code.modules()) | set(in_libraries)


def test_an_artifact_of_other_sources_is_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = cast("EntryKernel[Any, Any]", trace_many)
    assert machine_code.entry(kernel) is not None
    monkeypatch.setattr(source_hash, "current", lambda: {"sources": "others"})
    monkeypatch.setattr(machine_code, "modules", machine_code.modules.__wrapped__)
    assert machine_code.entry(kernel) is None


def test_threads_may_be_the_first_to_call_a_kernel_at_once() -> None:
    """Every thread finds machine code, with all its parts from one wasmtime engine."""
    kernel = cast("EntryKernel[Any, Any]", trace_many)
    found: list[machine_code.Machine] = []
    module = machine_code.modules.__wrapped__()[kernel.name]
    together = threading.Barrier(4)

    def first() -> None:
        together.wait()
        found.append(module.take())

    threads = [threading.Thread(target=first) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(set(found)) == 4


def sampled(out: Floats) -> None:
    """Write the states of a drop at its first impacts to `out`; the drop's arrays are read-only."""
    path = drop(Board.preset("triangle-8"), 5).trajectory
    rows = np.arange(len(out))
    assert not path.segments.flags.writeable
    times = path.segments[rows, body.T].copy()
    sample(arrays_of(path.board), path.segments, rows, rows + 1, times, False, new_series(), out)


def test_arrays_may_be_locked_and_have_gaps() -> None:
    whole = np.zeros((4, body.SIZE))
    gaps = np.zeros((8, body.SIZE))
    sampled(whole)
    sampled(gaps[::2])
    assert whole.any(axis=1).all()
    assert gaps[::2].tobytes() == whole.tobytes()
    assert not gaps[1::2].any()


def test_a_board_kept_in_memory_neither_changes_nor_mixes() -> None:
    """Drops on one board repeatedly, by more than one kernel, and on another board in between."""
    names = ("triangle-8", "triangle-8", "classic", "triangle-8")
    first, again, other, last = [
        drop(Board.preset(name), 5).to_dict(certainty=True) for name in names
    ]
    assert first == again == last
    assert other["digest"] != first["digest"]


def test_another_kind_of_array_is_refused() -> None:
    with pytest.raises(TypeError, match=r"sample takes an array f8:2, not float32 in 2 dimensions"):
        sampled(np.zeros((4, body.SIZE), np.float32))


def test_a_call_in_place_uses_its_views_and_spares_its_arguments() -> None:
    board = arrays_of(Board.preset("triangle-8"))
    log, states = new_log(64, 64), at_rest(np.array([0.01]), -0.5)
    ends = np.empty(1, np.int8), np.empty(1, np.int32), np.empty(1, np.int32)
    given = states.copy()
    rest = (500, MAX_TIME, new_series(), log, *ends)
    call = in_place(trace_many, board, states, in_flight(1), *rest)
    view = call.view(states)
    found = []
    for x in (0.01, 0.02, 0.01):
        view[:] = at_rest(np.array([x]), -0.5)
        call.view(log.counts)[:] = 0
        call.run()
        found.append(view.tobytes())
    assert states.tobytes() == given.tobytes()
    assert found[0] == found[2] != found[1]
    states[:] = given
    trace_many(board, states, in_flight(1), 500, MAX_TIME, new_series(), new_log(64, 64), *ends)
    assert states.tobytes() == found[0]


def test_a_drop_that_was_stopped_costs_the_next_one_nothing(limited_calls: None) -> None:
    board = Board.preset("triangle-12")
    before = drop(board, 3).digest
    with pytest.raises(EffortError, match="trace_many has not ended"):
        limits.at_most(1000, drop, board, 3)
    assert drop(board, 3).digest == before


def digests() -> list[str]:
    """Digests of drops by both solvers, of a batch, and of a heap of balls."""
    names = ("triangle-8", "classic", "scene:comb")
    boards = [check.board_of(name) for name in names]
    found = [drop(each, 3, solver=s).digest for each in boards for s in ("exact", "stepped")]
    heap = sandbox(12, width=1.6, height=1.2, seed=3, radii=(0.05, 0.1), speed=3.0)
    for _ in range(40):
        heap.step()
    return [*found, drop_many("galton", range(40)).digest, heap.digest]


@pytest.mark.long("numba compiles for a minute")
def test_numba_gives_the_artifacts_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    from plinko.engine.jit import kernel_compiler

    expected = digests()
    for kernel in entries().values():
        monkeypatch.setattr(kernel, "machine_code", kernel_compiler.compiled(kernel))
    assert digests() == expected
