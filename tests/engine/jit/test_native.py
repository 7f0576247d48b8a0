"""Native code has no imports or fused operations, and runs only with WebAssembly's bits."""

import json
import logging
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from hashlib import sha256
from threading import Event
from typing import Any

import pytest

from plinko.engine import Board, drop_many
from plinko.engine.drops import batch
from plinko.engine.exact.lanes import trial
from plinko.engine.exact.lanes.trace import Code
from plinko.engine.jit import limits, native, source_hash
from tests.engine.jit import elf
from tests.kit.python import run_python

LIBRARIES = sorted(native.FOLDER.glob("*.so"))


@pytest.fixture(autouse=True)
def _fresh(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Act as a new process, in which native code was neither tried nor forbidden."""
    monkeypatch.setattr(native, "_forbidden", Event())
    trial._tried.cache_clear()
    yield
    trial._tried.cache_clear()


@pytest.fixture
def code() -> Mapping[str, Code]:
    """This machine's native code; tests are skipped if it does not exist."""
    try:
        return native.load()
    except native.NoNativeCodeError as reason:
        pytest.skip(str(reason))


def test_there_is_a_library_for_each_kind_of_processor() -> None:
    assert {path.stem for path in LIBRARIES} == {"x86-64-v3", "x86-64-v4", "aarch64"}
    said = json.loads(native.INDEX.read_bytes())
    assert source_hash.is_of(source_hash.current(), said)
    for path in LIBRARIES:
        assert said["libraries"][path.stem] == sha256(path.read_bytes()).hexdigest()
        assert path.stat().st_size <= 150_000


@pytest.mark.parametrize("path", LIBRARIES, ids=lambda path: path.stem)
def test_a_library_asks_for_nothing(path: Any) -> None:
    assert elf.asks_for(path.read_bytes()) == []


@pytest.mark.parametrize(
    "line", ["\tvfmadd213sd\t%xmm0, %xmm1, %xmm2", "\tvfnmsub231pd %zmm0, %zmm1, %zmm2",
             "\tfmadd\td0, d1, d2, d3", "\tfmla\tv0.2d, v1.2d, v2.2d", "\tfnmsub d0, d1, d2, d3"],
)  # fmt: skip
def test_a_fused_instruction_is_seen(line: str) -> None:
    from plinko.engine.jit.native_code import check_listing

    harmless = "\tvmulpd\t%ymm0, %ymm1, %ymm2\n\tfmul\td0, d1, d2\nfmadd_label:\n"
    check_listing(harmless)
    with pytest.raises(ValueError, match="fuses"):
        check_listing(f"{harmless}{line}\n")


def test_native_code_gives_webassembly_s_bits(code: Mapping[str, Code]) -> None:
    dull = replace(Board.preset("triangle-8"), drag=20.0)
    for board in (*trial._boards(), Board.preset("galton"), dull):
        assert trial.agree(board, code)


def test_a_long_batch_runs_by_it_and_a_short_one_does_not(
    code: Mapping[str, Code], monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def counted(name: str, kernel: Code) -> Code:
        def run(*args: Any) -> None:
            calls.append(name)
            kernel(*args)

        return run

    spied = {name: counted(name, kernel) for name, kernel in code.items()}
    expected = drop_many("triangle-8", range(batch.WORTH_A_TRIAL - 1)).digest
    monkeypatch.setattr(native, "load", lambda: spied)
    assert drop_many("triangle-8", range(batch.WORTH_A_TRIAL - 1)).digest == expected
    assert not calls
    found = drop_many("triangle-8", range(batch.WORTH_A_TRIAL))
    assert found[:-1].digest == expected
    assert len(calls) > len(trial._boards())


def test_code_with_another_bit_is_not_trusted(
    code: Mapping[str, Code], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def off(kernel: Code) -> Code:
        def run(board: Any, drops: Any, space: Any, results: Any) -> None:
            kernel(board, drops, space, results)
            results.durations.view("i8")[-1] ^= 1

        return run

    monkeypatch.setattr(native, "load", lambda: {name: off(code[name]) for name in code})
    assert trial.trusted() == {}
    assert trial.trusted() == {}
    assert [record.message for record in caplog.records] == [
        "batches are computed by WebAssembly: native code gives other bits on triangle-16"
    ]


@pytest.mark.parametrize(
    ("name", "change", "reason"),
    [
        ("switch", lambda patch: patch.setenv(native.SWITCH, "0"), "PLINKO_NATIVE turns native"),
        ("system", lambda patch: patch.setattr("sys.platform", "plan9"), "no native code for this"),
        ("flags", lambda patch: patch.setattr(native, "_flags", set), "no native code for this"),
        ("sources", lambda patch: patch.setattr(source_hash, "current", lambda: {"sources": ""}),
         "out of date"),
        ("folder", lambda patch: patch.setattr(native, "INDEX", native.FOLDER / "none.json"),
         "cannot be loaded"),
    ],
)  # fmt: skip
def test_webassembly_goes_on_and_one_line_says_why(
    name: str,
    change: Any,
    reason: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    caplog.set_level(logging.INFO)
    change(monkeypatch)
    for _ in range(2):
        assert trial.trusted() == {}
    if "NUMBA_DISABLE_JIT" not in os.environ:
        (line,) = caplog.records
        assert reason in line.message, name


def test_a_library_that_has_changed_is_not_loaded(
    code: Mapping[str, Code], monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    for path in LIBRARIES:
        (tmp_path / path.name).write_bytes(path.read_bytes() + b"\0")
    monkeypatch.setattr(native, "FOLDER", tmp_path)
    with pytest.raises(native.NoNativeCodeError, match="has changed since it was made"):
        native.load()


@pytest.mark.parametrize("forbid", [native.forbid, limits.limit_calls])
def test_a_process_that_computes_for_others_runs_no_native_code(
    forbid: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "_limited", Event())
    monkeypatch.delattr(native, "load")  # a call of it would fail
    forbid()
    assert trial.trusted() == {}


def test_a_server_s_workers_run_no_native_code() -> None:
    """They have imported this module."""
    said = "from plinko.engine.jit import native; print(native.is_forbidden())"
    assert run_python(f"import plinko.app.computing.preloaded; {said}") == "True\n"


def test_arrays_are_taken_as_they_are_or_refused(code: Mapping[str, Code]) -> None:
    from plinko.engine.constants import MAX_TIME
    from plinko.engine.exact.board_arrays import arrays_of
    from plinko.engine.exact.lanes.lane import new_space
    from plinko.engine.exact.lanes.trace import Drops
    from plinko.engine.exact.outcome import MAX_EVENTS, new_results
    from tests.engine.exact.test_lanes import starts

    board = Board.preset("triangle-8")
    arrays = arrays_of(board)
    with_gaps = starts(board, 20)[::2]
    (kernel, _) = code.values()
    drops = Drops(with_gaps, board.drop.y, MAX_EVENTS, MAX_TIME)
    with pytest.raises(TypeError, match="takes an array f8:1 without gaps"):
        kernel(arrays, drops, new_space(arrays), new_results(10))
