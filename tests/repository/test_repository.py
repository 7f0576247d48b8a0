"""Rules for every file of the repository, and for its packaging."""

import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from plinko import engine

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CODE = sorted(
    path
    for folder in ("engine", "app", "src", "benchmarks", "deploy", "tests", "static", "tools")
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
    """A distribution's name in the form in which indexes compare names."""
    return re.sub(r"[-_.]+", "-", name).lower()


def says_what_it_is_for(path: Path) -> bool:
    return path.read_text(encoding="utf-8").startswith(OPENINGS[path.suffix])


def test_every_file_says_first_what_it_is_for() -> None:
    files = [path for path in CODE if path.suffix in OPENINGS and path.stat().st_size]
    assert [path for path in files if not says_what_it_is_for(path)] == []


def test_no_file_names_a_place_on_one_machine() -> None:
    texts = [path for path in CODE if path.suffix in TEXTS]
    assert [path for path in texts if MACHINE_PATH.search(path.read_text(encoding="utf-8"))] == []


def test_every_dependency_is_pinned_to_an_exact_version() -> None:
    project = PROJECT["project"]
    wanted = ["pip", *project["dependencies"]]
    for extra in (
        *project["optional-dependencies"].values(),
        *PROJECT["dependency-groups"].values(),
    ):
        wanted += [line for line in extra if isinstance(line, str)]
    names = {canonical(re.match(r"[\w.-]+", line)[0]) for line in wanted}  # type: ignore[index]
    assert names <= {canonical(name) for name in pinned()}
    assert "://" not in (ROOT / "constraints.txt").read_text(encoding="utf-8")


def test_no_file_records_where_packages_are_downloaded() -> None:
    for name in ("poetry.lock", "uv.lock", "pdm.lock", "Pipfile.lock", "package-lock.json"):
        assert not (ROOT / name).exists()


def test_the_changelog_knows_this_version_or_what_is_to_come() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## \[(.+?)\]", text, re.MULTILINE)
    assert versions[0] in {"Unreleased", engine.__version__}


def test_the_image_copies_what_the_wheel_is_made_of() -> None:
    targets = PROJECT["tool"]["hatch"]["build"]["targets"]
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    (package,) = targets["wheel"]["packages"]
    for name in (package.partition("/")[0], *targets["sdist"]["force-include"]):
        assert f"COPY {name} {name}\n" in docker
        assert f"!{name}" in ignored


SCRIPTS = [
    ROOT / ".ci" / "run",
    *(path for path in ROOT.glob("tools/*") if path.is_file() and not path.suffix),
]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_can_be_run_and_is_sound_shell(path: Path) -> None:
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
    """IEEE 754 defines these functions to the last bit; others may differ between machines."""
    files = [path.read_text(encoding="utf-8") for path in (ROOT / "engine").rglob("*.py")]
    kernels = [text for text in files if re.search(r"^@(inner_|lean_)?kernel$", text, re.MULTILINE)]
    assert kernels
    for text in kernels:
        taken = re.findall(r"^from math import (.*)$", text, re.MULTILINE)
        assert {name for names in taken for name in names.split(", ")} <= {
            "ceil",
            "copysign",
            "inf",
            "sqrt",
        }
        assert not re.search(r"^import math|np\.(exp|log|sin|cos|tan|hypot|power)\(", text)
