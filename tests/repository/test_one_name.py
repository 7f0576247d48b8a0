"""One name, `plinko`: beside files called engine.py and app.py, and in every kind of process."""

import subprocess
import sys
from pathlib import Path

import pytest

import plinko
from tests.repository.conftest import ROOT, Installed

SCRIPT = """
import asyncio, functools, multiprocessing, sys
import app, engine
import plinko
from plinko import *

def own(x):
    return engine.NAME, x

if __name__ == "__main__":
    assert all(globals()[name] is getattr(plinko, name) for name in plinko.__all__)
    from plinko.app.computing.pool import Workers
    there = drop("triangle-8", 42)
    for method in ("fork", "spawn", "forkserver"):
        with multiprocessing.get_context(method).Pool(1) as pool:
            assert pool.apply(drop, (Board.preset("triangle-8"), 42)) == there, method
            assert pool.apply(drop_many, ("triangle-8", 9)) == drop_many("triangle-8", 9), method
            assert pool.apply(own, (1,)) == ("engine.py", 1), method
    async def work():
        workers = Workers(1, 1)
        try:
            return await workers.run(functools.partial(drop, "triangle-8", 42))
        finally:
            workers.close()
    assert asyncio.run(work()) == there
    print(app.NAME, engine.NAME, there.digest)
"""


@pytest.fixture(params=["installed", "editable"])
def environment(request: pytest.FixtureRequest) -> Installed:
    found: Installed = request.getfixturevalue(request.param)
    return found


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A user's folder, with modules that are named like folders of Plinko's source."""
    for name in ("engine", "app", "static"):
        (tmp_path / f"{name}.py").write_text(f"NAME = '{name}.py'\n")
    return tmp_path


def test_a_script_beside_engine_and_app_uses_every_name_in_every_kind_of_process(
    environment: Installed, project: Path
) -> None:
    (project / "study.py").write_text(SCRIPT)
    done = environment.run("python", str(project / "study.py"), cwd=project)
    digest = plinko.drop("triangle-8", 42).digest
    assert (done.stdout, done.stderr) == (f"app.py engine.py {digest}\n", "")


@pytest.mark.parametrize("command", [["plinko"], ["python", "-m", "plinko"]], ids=" ".join)
def test_the_command_runs_beside_engine_and_app(
    environment: Installed, project: Path, command: list[str]
) -> None:
    done = environment.run(
        *command, "simulate", "triangle-8", "--drops", "9", "--cluster", "local:1", cwd=project
    )
    assert plinko.drop_many("triangle-8", 9).digest in done.stdout, done.stderr


TWICE = """
import os, sys, plinko, plinko.app.main, plinko.app.cli.drops.drop
for name in plinko.__all__: getattr(plinko, name)
files = {}
for name, module in list(sys.modules.items()):
    if getattr(module, "__file__", None):
        files.setdefault(os.path.realpath(module.__file__), set()).add(module)
ours = os.path.dirname(os.path.dirname(os.path.realpath(plinko.drop.__code__.co_filename)))
assert any(file.startswith(ours) for file in files)
print([modules for modules in files.values() if len(modules) > 1])
"""


@pytest.mark.parametrize("folder", [".", "src/plinko", "engine"])
def test_a_module_is_one_object_in_every_folder_of_the_source(
    editable: Installed, folder: str
) -> None:
    assert editable.python(TWICE, cwd=ROOT / folder) == "[]\n"


@pytest.mark.parametrize("folder", [".", "src/plinko"])
@pytest.mark.parametrize("name", ["engine", "app"])
def test_a_second_copy_is_refused_with_the_right_name(
    editable: Installed, name: str, folder: str
) -> None:
    done = editable.run("python", "-c", f"import {name}.errors", cwd=ROOT / folder)
    said = f"ImportError: {name} is the source of plinko.{name}: import plinko.{name}\n"
    assert done.stderr.endswith(said)


@pytest.mark.parametrize("name", ["engine", "app", "static"])
def test_an_installed_package_has_no_other_name(environment: Installed, name: str) -> None:
    code = "from importlib.util import find_spec as find; s = find({!r}); print(s and s.origin)"
    assert environment.python(code.format(name)) == "None\n"


def test_a_type_checker_finds_every_name_and_no_misspelt_one(
    environment: Installed, project: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    cache = tmp_path_factory.getbasetemp() / "mypy"  # both environments have the same dependencies
    lines = ["import plinko", *(f"plinko.{name}" for name in plinko.__all__)]
    lines += [
        "from plinko.engine.board.model import Board",
        "d = plinko.drop(Board.triangle(8), 1)",
    ]
    lines += ["reveal_type(d.bin)", "plinko.dropp"]
    (project / "study.py").write_text("\n".join(lines) + "\n")
    there = ["--python-executable", str(environment.folder / "bin" / "python")]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *there, "--cache-dir", cache, "study.py"],
        cwd=project,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == [
        f'study.py:{len(lines) - 1}: note: Revealed type is "int | None"',
        f'study.py:{len(lines)}: error: Module has no attribute "dropp"  [attr-defined]',
        "Found 1 error in 1 file (checked 1 source file)",
    ]
