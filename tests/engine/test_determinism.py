"""The same bits everywhere: golden digests, with and without the JIT, and no stale machine code."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba import types

from engine import PHYSICS_VERSION, Board, drop
from engine.exact.board_arrays import arrays_of, bin_of
from engine.jit import kernel_compiler
from engine.physics.surface import side_of
from engine.physics.time_of_impact import stays_positive
from tests.golden import check, make

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", check.names())
def test_a_drop_has_its_golden_digest(name: str) -> None:
    expected = check.golden()["drops"][name]
    assert check.differences(expected, check.entry(name), name) == []


@pytest.mark.parametrize("name", check.batch_names())
def test_a_thousand_drops_have_their_golden_digest(name: str) -> None:
    expected = check.golden()["batches"][name]
    assert check.differences(expected, check.batch_entry(name), name) == []


def test_the_golden_digests_are_of_this_physics_and_cover_every_board() -> None:
    golden = check.golden()
    assert golden["physics_version"] == PHYSICS_VERSION
    assert golden["seeds"] == [str(seed) for seed in check.SEEDS]
    assert set(golden["drops"]) == set(check.names())
    assert set(golden["batches"]) == set(check.batch_names())
    digests = [d for entry in golden["drops"].values() for s in check.SOLVERS for d in entry[s]]
    assert len(set(digests)) == len(digests)


def test_a_version_of_the_physics_has_its_entry_in_the_changelog() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    sections = [part for part in changelog.split("\n### ") if part.startswith("Simulation results")]
    assert any(f"`PHYSICS_VERSION` {PHYSICS_VERSION}" in section for section in sections)


def run_python(code: str, folder: Path = ROOT, **environment: str) -> str:
    """What a fresh interpreter prints for `code` in `folder`."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_plain_python_gives_the_golden_digests() -> None:
    """Every preset and scene by both solvers, one drop each: the kernels without the JIT."""
    code = (
        "import sys, engine.exact.trace as exact\n"
        "assert not hasattr(exact.trace_many, 'signatures'), 'the JIT is on'\n"
        "from tests.golden import check\n"
        "sys.exit(check.main(['--quick']))\n"
    )
    printed = run_python(code, NUMBA_DISABLE_JIT="1")
    assert printed.startswith(f"{2 * len(check.names())} drops have the golden digests")


def test_a_changed_bit_is_told_by_name() -> None:
    expected = check.golden()["drops"]["triangle-8"]
    spoiled = json.loads(json.dumps(expected))
    spoiled["stepped"][2] = "0" * 64
    lines = check.differences(spoiled, expected, "triangle-8")
    assert len(lines) == 1
    assert lines[0].startswith(f"triangle-8 stepped seed {check.SEEDS[2]}: ")


def test_results_cannot_change_behind_the_versions_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The maker refuses; it agrees to a raised version, and to boards that are new."""
    entry = check.golden()["drops"]["triangle-8"]
    old = {"physics_version": 1, "seeds": [], "drops": {"triangle-8": entry}, "batches": {}}
    file = tmp_path / "digests.json"
    monkeypatch.setattr(check, "FILE", file)
    changed = json.loads(json.dumps(old))
    changed["drops"]["triangle-8"]["exact"][0] = "0" * 64
    monkeypatch.setattr(check, "current", lambda: changed)

    file.write_text(json.dumps(old))
    assert make.main([]) == 1
    assert "raise PHYSICS_VERSION first" in capsys.readouterr().out
    assert json.loads(file.read_text()) == old

    changed["physics_version"] = 2
    assert make.main([]) == 0
    assert json.loads(file.read_text()) == changed

    more = json.loads(json.dumps(changed))
    more["drops"]["another"] = entry
    monkeypatch.setattr(check, "current", lambda: more)
    assert make.main([]) == 0
    monkeypatch.setattr(check, "current", lambda: changed)
    assert make.main([]) == 1  # a board that goes takes its drops with it
    assert make.main(["--initial"]) == 0


@pytest.mark.parametrize("plain", ["0", "1"])
def test_a_changed_kernel_makes_the_code_of_its_callers_stale(plain: str, tmp_path: Path) -> None:
    """In a copy of the engine: a root is found with the series of another file."""
    package = tmp_path / "engine"
    for folder in ("jit", "physics"):
        shutil.copytree(ROOT / "engine" / folder, package / folder)
    shutil.copy(ROOT / "engine" / "constants.py", package)
    (package / "__init__.py").write_text("")
    code = (
        "from engine.physics.line_impact import line_hit_again\n"
        "print(round(line_hit_again(1.0, -2.0, 1e-12, 9.0, 9.0), 6))\n"
    )
    cache = {
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        kernel_compiler.PLAIN_SWITCH: plain,
    }
    assert run_python(code, tmp_path, **cache) == "1.0\n"
    source = package / "physics" / "flight.py"
    text = source.read_text()
    assert "_C0 = 1.0 / 2.0" in text
    source.write_text(text.replace("_C0 = 1.0 / 2.0", "_C0 = 1.0 / 4.0"))
    assert run_python(code, tmp_path, **cache) == "2.0\n"
    source.write_text(text)
    assert run_python(code, tmp_path, **cache) == "1.0\n"


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_a_constant_argument_compiles_no_kernel_of_its_own() -> None:
    compiled: Any = stays_positive
    two: Any = types.IntegerLiteral(2)
    compiled.get_call_template((types.float64, types.float64, two, types.int64), {})
    kinds = {kind for signature in compiled.signatures for kind in signature}
    assert types.int64 in kinds
    assert not any(isinstance(kind, types.Literal) for kind in kinds)


def test_a_kernel_inside_of_others_runs_as_python_when_python_calls_it() -> None:
    """Before and after it was compiled into another: numba would jump to a wrapper never made."""
    arrays = arrays_of(Board.preset("triangle-8"))
    first = bin_of(arrays, 0.1)
    drop(Board.preset("triangle-8"), 1)
    assert bin_of(arrays, 0.1) == first == 4
    assert side_of(arrays.items, 0, 0.0, 0.0) == 0.0


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_only_kernels_that_python_calls_have_machine_code_of_their_own(tmp_path: Path) -> None:
    """`basis` is one; `follow_flight`, `bin_of` and others are inside of `trace_many`."""
    kept = kept_code(
        "from engine import Board, drop\ndrop(Board.preset('triangle-8'), 1)\n", tmp_path
    )
    assert {"trace.trace_many", "flight.basis"} <= kept
    assert (
        not {
            "free_flight.follow_flight",
            "next_impact.next_impact",
            "board_arrays.bin_of",
            "sustained_contact.follow_contact",
        }
        & kept
    )


@pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")
def test_drops_that_only_bounce_compile_nothing_for_those_that_roll(tmp_path: Path) -> None:
    code = (
        "from dataclasses import replace\n"
        "from engine import Board, drop_many\n"
        "board = Board.preset('triangle-8')\n"
        "board = replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))\n"
        "drop_many(board, range(2))\n"
    )
    kept = kept_code(code, tmp_path)
    assert "trace._trace_lanes" in kept
    assert "trace.trace_many" not in kept


def kept_code(code: str, cache: Path) -> set[str]:
    """The kernels whose machine code a program in Python leaves on disk, as file.function."""
    run_python(code, ROOT, NUMBA_CACHE_DIR=str(cache))
    return {path.name.split("-")[0] for path in cache.rglob("*.nbc")}


def test_the_stamp_is_of_all_kernels() -> None:
    """`jit` itself, which says how they are compiled, is a source as well."""
    uses = "engine.jit.decorator"
    kernels = {p for p in (ROOT / "engine").rglob("*.py") if uses in p.read_text(encoding="utf-8")}
    assert len(kernels) > 20
    assert kernels <= set(kernel_compiler.sources())
    assert Path(kernel_compiler.__file__) in kernel_compiler.sources()
