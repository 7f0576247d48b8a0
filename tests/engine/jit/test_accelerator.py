"""In long computations numba's code takes the artifact's place, and nobody sees it by the bits."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from engine import Board, drop_many
from engine.certified.reach import first_reaches
from engine.drops import batch
from engine.jit import accelerator
from engine.jit.accelerator import Accelerator, State
from engine.jit.compilation import named

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")


REACHES = "engine.certified.reach.first_reaches"
"""A kernel that numba compiles in a second."""


@pytest.fixture(autouse=True)
def _allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(accelerator, "_forbidden", threading.Event())


@pytest.fixture
def hasten() -> Iterator[Callable[[str, str, float], Accelerator]]:
    """Accelerators whose kernels run by artifacts again afterwards."""
    made = []

    def hastened(name: str, play: str, enough: float) -> Accelerator:
        kernel = named(name)
        made.append((kernel, kernel.machine_code))
        return Accelerator(name, play, enough)

    yield hastened
    for kernel, code in made:
        kernel.machine_code = code


def cached(name: str) -> int:
    """How many codes of a kernel numba has read; it must have compiled none here."""
    stats = named(name).machine_code.stats
    assert not stats.cache_misses
    return sum(stats.cache_hits.values())


def reaches() -> bytes:
    """What a kernel leaves."""
    numbers, times = np.zeros(2, np.int64), np.zeros(2)
    state = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 9.81])
    circles = np.array([[0.05, 1.0, 0.1], [0.1, 2.0, 0.1]])
    found = first_reaches(
        state, 0.02, np.full(3, 1e-9), 1e-9, -1, circles, np.zeros((0, 7)), np.ones(6), numbers,
        times,
    )  # fmt: skip
    return repr(found).encode() + numbers.tobytes() + times.tobytes()


def test_after_much_work_numba_compiles_beside_it_and_takes_over(
    hasten: Callable[..., Accelerator],
) -> None:
    hastened = hasten(REACHES, "certified", enough=10.0)
    expected = reaches()
    states = []
    for work in (9.0, 1.0):
        hastened.did(work)
        states.append(hastened.state)
        assert reaches() == expected
    hastened.compilation.wait()
    hastened.did(0.0)
    assert [*states, hastened.state] == [State.WAITING, State.COMPILING, State.DONE]
    assert reaches() == expected
    assert cached(REACHES) == 1


def test_where_there_is_no_numba_the_artifact_goes_on(
    hasten: Callable[..., Accelerator], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(accelerator, "find_spec", lambda name: None)
    hastened = hasten(REACHES, "certified", enough=1.0)
    hastened.did(1.0)
    assert hastened.state is State.OFF


def test_a_server_forbids_it(hasten: Callable[..., Accelerator]) -> None:
    accelerator.forbid()
    hastened = hasten(REACHES, "certified", enough=1.0)
    hastened.did(1.0)
    assert hastened.state is State.OFF


@pytest.mark.parametrize("program", ["/nowhere/python", "/bin/false"])
def test_where_it_cannot_compile_the_artifact_goes_on(
    program: str, hasten: Callable[..., Accelerator], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", program)
    hastened = hasten(REACHES, "certified", enough=1.0)
    before = named(REACHES).machine_code
    hastened.did(1.0)
    if hastened.compilation is not None:
        hastened.compilation.wait()
    hastened.did(0.0)
    assert hastened.state is State.OFF
    assert named(REACHES).machine_code is before


@pytest.mark.long("numba compiles for a quarter of a minute")
def test_a_batch_has_the_same_bits_when_numba_takes_over_in_its_midst(
    hasten: Callable[..., Accelerator], monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board.preset("triangle-16")
    smooth = replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))
    expected = drop_many(smooth, range(4000)).digest
    hastened = hasten(batch.LOCKSTEP.kernel, batch.LOCKSTEP.play, enough=1.0)
    monkeypatch.setattr(batch, "LOCKSTEP", hastened)
    states = []

    def progress(_: int) -> None:
        states.append(hastened.state)
        hastened.compilation.wait()

    assert drop_many(smooth, range(4000), threads=1, progress=progress).digest == expected
    assert states[0] is State.COMPILING
    assert states[-1] is State.DONE
    assert cached(hastened.kernel) == 1
