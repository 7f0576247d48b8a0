"""The ways to compile kernels: plain numba gives the fast way's bits, and takes its place."""

import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core.cpu import CPUContext

from benchmarks.scenes import boards
from benchmarks.speed import throughput
from engine import drop_many
from engine.jit import fast_compile, kernel_compiler
from engine.multibody.scenes import sandbox
from tests.golden import check

ROOT = Path(__file__).parents[3]

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")

GOLDEN = ("triangle-8", "classic", "scene:comb")


@pytest.fixture(autouse=True)
def _no_switch(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test depends on the way that the user chose."""
    monkeypatch.delenv(kernel_compiler.PLAIN_SWITCH, raising=False)


def digests() -> dict[str, Any]:
    """Of drops by both solvers, of many in lockstep, and of an arena after 40 steps."""
    thin = boards.lattice(12, 24, throughput.THIN)
    arena = sandbox(
        12, width=1.6, height=1.2, restitution=0.6, seed=3, radii=(0.05, 0.1), speed=3.0
    )
    for _ in range(40):
        arena.step()
    return {
        "drops": {name: check.entry(name, 2) for name in GOLDEN},
        "lockstep": drop_many(thin, range(40)).digest,
        "arena": arena.digest(),
    }


def test_plain_numba_gives_the_same_digests_and_warns_once() -> None:
    program = (
        "import json, numba\n"
        "numba.__version__ = '0.99.0'\n"
        "from engine.jit import decorator\n"
        "assert decorator._way.name == 'plain'\n"
        "from tests.engine.jit.test_kernel_compiler import digests\n"
        "print(json.dumps(digests()))\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "always", "-c", program],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    plain = json.loads(done.stdout)
    assert plain == digests()
    expected = check.golden()["drops"]
    for name in GOLDEN:
        assert check.differences(expected[name], plain["drops"][name], name) == []
    assert re.findall(r"\b\w*Warning: .*", done.stderr) == [
        "RuntimeWarning: kernels compile slowly, with the same results: UnknownNumbaError: numba "
        f"0.99.0 is none of those tried, {tried()} (PLINKO_PLAIN_NUMBA=1 chooses this without a "
        "warning)"
    ]


def tried() -> str:
    """The versions that a warning names."""
    return ", ".join(f"{major}.{minor}" for major, minor in fast_compile.TRIED)


def choice() -> tuple[str, list[str]]:
    """The way that is chosen, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        name = kernel_compiler.choose().name
    return name, [str(each.message) for each in caught]


def test_the_pinned_numba_goes_the_fast_way() -> None:
    pinned = re.search(r"^numba==(\d+)\.(\d+)", (ROOT / "constraints.txt").read_text(), re.M)
    assert pinned is not None
    assert (int(pinned[1]), int(pinned[2])) in fast_compile.TRIED
    assert choice() == ("fast", [])


@pytest.mark.parametrize("version", ["0.60.0", "0.99.0dev1", "1.0.0", "0.6.8"])
def test_another_numba_goes_the_plain_way(version: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba, "__version__", version)
    name, (warning,) = choice()
    assert name == "plain"
    assert f"numba {version} is none of those tried" in warning


def test_whoever_chooses_the_plain_way_is_not_warned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba, "__version__", "0.99.0")
    monkeypatch.setenv(kernel_compiler.PLAIN_SWITCH, "1")
    assert choice() == ("plain", [])


@pytest.mark.parametrize(
    "name",
    [
        "codegen.JITCodeLibrary._optimize_final_module",
        "codegen.JITCodeLibrary._finalize_final_module",
        "base.BaseContext.insert_user_function",
        "compiler.CompilerBase.compile_extra",
        "compiler.Compiler.define_pipelines",
        "compiler.InlineOverloads",
        "dispatcher._DispatcherBase.get_call_template",
        "dispatcher._DispatcherBase._compile_for_args",
        "options.DefaultOptions.no_rewrites",
        "typing.context.BaseContext._lookup_global",
    ],
)
def test_without_a_private_name_numba_goes_the_plain_way(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(f"numba.core.{name}")
    way, (warning,) = choice()
    assert way == "plain"
    assert name.rpartition(".")[2] in warning


def test_another_signature_of_a_private_name_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CPUContext, "get_function", lambda self, fn, sig: None)
    way, (warning,) = choice()
    assert way == "plain"
    assert "get_function does not take self, fn, sig, _firstcall" in warning


def test_a_numba_without_what_is_imported_goes_the_plain_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, "engine.jit.fast_compile")
    monkeypatch.delattr("numba.core.codegen.JITCodeLibrary")
    way, (warning,) = choice()
    assert way == "plain"
    assert "ImportError: cannot import name 'JITCodeLibrary'" in warning


def halved(x: float) -> float:
    return 0.5 * x


def test_plain_code_is_kept_in_a_folder_of_its_stamp() -> None:
    config: Any = numba.config
    before = config.CACHE_DIR
    for stamp in "ab":
        compiled = kernel_compiler.PLAIN.outer(halved, stamp * 64)
        assert f"plain-{stamp * 16}" in Path(compiled.stats.cache_path).parts
    assert before == config.CACHE_DIR


def test_no_plain_code_is_kept_where_its_stamp_cannot_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "InTreeCacheLocator")
    compiled = kernel_compiler.PLAIN.outer(halved, "a" * 64)
    assert compiled.stats.cache_path is None
    assert compiled(3.0) == 1.5
