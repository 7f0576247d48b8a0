"""The ways to compile kernels: plain numba gives the fast way's bits, and takes its place."""

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
from engine import drop, drop_many
from engine.jit import fast_compile, kernel_compiler
from engine.multibody.scenes import sandbox
from tests.golden import check
from tests.long import tries

ROOT = Path(__file__).parents[3]

pytestmark = pytest.mark.skipif("NUMBA_DISABLE_JIT" in os.environ, reason="nothing is compiled")

GOLDEN = ("triangle-8", "classic", "scene:comb")


@pytest.fixture(autouse=True)
def _no_switch(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test depends on the way that the user chose."""
    monkeypatch.delenv(kernel_compiler.PLAIN_SWITCH, raising=False)


def drops(solver: str) -> list[str]:
    """Digests of golden drops: one that rolls and slides, and some that mostly bounce."""
    return [drop(check.board_of(name), check.SEEDS[0], solver=solver).digest for name in GOLDEN]


def golden(solver: str) -> list[str]:
    """The committed digests of `drops`."""
    return [check.golden()["drops"][name][solver][0] for name in GOLDEN]


def lockstep() -> list[str]:
    """Digest of drops that only bounce, many at a time."""
    return [drop_many(boards.lattice(12, 24, throughput.THIN), range(40)).digest]


def arena() -> list[str]:
    """Digest of a heap of balls that touch, after 40 steps."""
    balls = sandbox(12, width=1.6, height=1.2, seed=3, radii=(0.05, 0.1), speed=3.0)
    for _ in range(40):
        balls.step()
    return [balls.digest()]


def with_another_numba(code: str) -> "subprocess.CompletedProcess[str]":
    """A fresh interpreter that runs `code` with a numba of a version that nobody tried."""
    done = subprocess.run(
        [
            sys.executable,
            "-W",
            "always",
            "-c",
            f"import numba\nnumba.__version__ = '0.99.0'\n{code}",
        ],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done


# Plain numba compiles the exact solver for a minute, the stepped one for a quarter of that.
PLAIN = tries(["drops('stepped')"], ["drops('stepped')", "drops('exact')", "lockstep()", "arena()"])


@pytest.mark.long
@pytest.mark.parametrize("call", PLAIN)
def test_plain_numba_gives_the_same_digests(call: str) -> None:
    code = (
        "from engine.jit import decorator\n"
        "assert decorator._way.name == 'plain'\n"
        "from tests.engine.jit import test_kernel_compiler as digests\n"
        f"print(*digests.{call})\n"
    )
    expected = {
        "drops('exact')": lambda: golden("exact"),
        "drops('stepped')": lambda: golden("stepped"),
        "lockstep()": lockstep,
        "arena()": arena,
    }
    assert with_another_numba(code).stdout.split() == expected[call]()


def test_another_numba_is_warned_of_once() -> None:
    said = with_another_numba("import engine, engine.jit.decorator").stderr
    assert re.findall(r"\b\w*Warning: .*", said) == [
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
        "codegen.CPUCodeLibrary._optimize_final_module",
        "base.BaseContext.insert_user_function",
        "compiler.CompilerBase.compile_extra",
        "compiler.InlineOverloads",
        "dispatcher._DispatcherBase.get_call_template",
        "dispatcher._DispatcherBase._compile_for_args",
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


def test_an_option_that_numba_does_not_know_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fast_compile, "_INNER_RULES", {"no_such_option": True})
    way, (warning,) = choice()
    assert way == "plain"
    assert "no_such_option" in warning


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
