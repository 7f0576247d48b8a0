"""What every file of the repository keeps to, and what its packaging promises."""

import importlib
import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

import engine
from app.cli import COMMANDS

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CODE = sorted(
    path
    for folder in ("engine", "app", "plinko", "benchmarks", "deploy", "tests", "static", "tools")
    for path in (ROOT / folder).rglob("*")
    if path.is_file() and "__pycache__" not in path.parts and "node_modules" not in path.parts
)
OPENINGS = {".py": '"""', ".js": "//", ".css": "/*"}
TEXTS = {*OPENINGS, ".html", ".json", ".md", ""}
MACHINE_PATH = re.compile(r"(?<![\w.$}])/(?:home|root|Users|work)/\w+")


def pinned() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return dict(
        re.fullmatch(r"([\w.-]+)==([\w.+!-]+)", line).groups()  # type: ignore[union-attr,misc]
        for line in lines
        if not line.startswith("#")
    )


def canonical(name: str) -> str:
    """A distribution's name as indexes compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def says_what_it_is_for(path: Path) -> bool:
    first, second = [*path.read_text(encoding="utf-8").splitlines(), "", ""][:2]
    return first.startswith(OPENINGS[path.suffix]) and max(len(first), len(second)) > 20


def test_every_file_says_first_what_it_is_for() -> None:
    files = [path for path in CODE if path.suffix in OPENINGS and path.stat().st_size]
    assert len(files) > 50
    assert [path for path in files if not says_what_it_is_for(path)] == []


def test_no_file_names_a_place_on_one_machine() -> None:
    texts = [path for path in CODE if path.suffix in TEXTS]
    assert len(texts) > 50
    assert [path for path in texts if MACHINE_PATH.search(path.read_text(encoding="utf-8"))] == []


def test_every_dependency_is_pinned_by_exact_version_and_no_address() -> None:
    project = PROJECT["project"]
    wanted = list(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        wanted += extra
    names = {canonical(re.match(r"[\w.-]+", line)[0]) for line in wanted}  # type: ignore[index]
    assert names <= {canonical(name) for name in pinned()}
    assert "://" not in (ROOT / "constraints.txt").read_text(encoding="utf-8")


def test_what_is_started_and_tested_has_the_server_and_its_proofs() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "ALL := server,certify\n" in makefile
    installs = re.findall(r"-c constraints\.txt -e (.+)", makefile)
    assert len(installs) == 6
    assert all(re.match(r"'\.\[\$\(ALL\)[],]", each) for each in installs)
    assert "'.[server,certify," in (ROOT / "Dockerfile").read_text(encoding="utf-8")


def test_no_file_records_where_packages_are_downloaded() -> None:
    for name in ("poetry.lock", "uv.lock", "pdm.lock", "Pipfile.lock", "package-lock.json"):
        assert not (ROOT / name).exists()


def test_each_command_has_a_file_of_its_name() -> None:
    folder = ROOT / "app" / "cli"
    files = {path.stem for path in folder.rglob("*.py")}
    assert files - {"__init__", "__main__", "common"} == set(COMMANDS)
    for name, module in COMMANDS.items():
        assert module.rpartition(".")[2] == name
        assert importlib.import_module(f"app.cli.{module}").command.name == name


def test_the_changelog_knows_this_version_or_what_is_to_come() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## \[(.+?)\]", text, re.MULTILINE)
    assert versions[0] in {"Unreleased", engine.__version__}


def test_a_wheel_carries_the_page_where_the_server_looks_for_it() -> None:
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["force-include"] == {"static": "app/static"}
    assert wheel["packages"] == ["engine", "app", "plinko"], "and not what measures them"
    # What the image copies is what the wheel is made of.
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    for name in (*wheel["packages"], *wheel["force-include"]):
        assert f"COPY {name} {name}\n" in docker
        assert f"!{name}" in ignored


@pytest.mark.parametrize(
    "script",
    [
        ".ci/run",
        "tools/make-venv",
        "tools/chromium",
        "tools/proxies",
        "tools/node",
        "tools/npm-package",
        "tools/postgresql",
        "tools/redis",
    ],
)
def test_a_script_can_be_run_and_is_sound_shell(script: str) -> None:
    path = ROOT / script
    assert os.access(path, os.X_OK)
    assert "set -euo pipefail" in path.read_text(encoding="utf-8")
    subprocess.run([shutil.which("bash") or "bash", "-n", str(path)], check=True)


def test_an_old_python_is_refused_with_both_versions_named(tmp_path: Path) -> None:
    old = tmp_path / "python-old"
    old.write_text('#!/bin/sh\ncase "$2" in *exit*) exit 1;; *) echo 3.9;; esac\n')
    old.chmod(0o755)
    done = subprocess.run(
        [ROOT / "tools" / "make-venv", old, tmp_path / "venv"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "Python 3.9" in done.stderr
    assert "3.11" in done.stderr
    assert not (tmp_path / "venv").exists()


def test_kernels_take_nothing_from_math_but_what_is_exact() -> None:
    """IEEE 754 defines these to the last bit; all else may differ from machine to machine."""
    files = [path.read_text(encoding="utf-8") for path in (ROOT / "engine").rglob("*.py")]
    kernels = [text for text in files if re.search(r"^@(inner_|lean_)?kernel$", text, re.MULTILINE)]
    assert len(kernels) > 20
    for text in kernels:
        taken = re.findall(r"^from math import (.*)$", text, re.MULTILINE)
        assert {name for names in taken for name in names.split(", ")} <= {
            "ceil",
            "copysign",
            "inf",
            "sqrt",
        }
        assert not re.search(r"^import math|np\.(exp|log|sin|cos|tan|hypot|power)\(", text)
