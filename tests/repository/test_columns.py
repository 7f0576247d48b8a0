"""The numbers of array columns are used with their module, such as `layout.LENGTH`."""

import ast
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "benchmarks", "engine", "tests")

COLUMN_MODULES = (
    "engine.exact.event_log",
    "engine.exact.initial_state",
    "engine.exact.lanes.flight",
    "engine.exact.lanes.impact",
    "engine.exact.lanes.lane",
    "engine.exact.lanes.search",
    "engine.exact.sensitivity",
    "engine.multibody.solver.layout.body",
    "engine.multibody.solver.layout.contact",
    "engine.multibody.solver.layout.hash_grid",
    "engine.multibody.solver.layout.pair",
    "engine.multibody.solver.layout.shape",
    "engine.multibody.solver.layout.step_log",
    "engine.multibody.solver.layout.sweep",
    "engine.physics.body",
    "engine.physics.contact",
    "engine.physics.surface",
    "engine.physics.tangent",
)
"""Modules whose int constants are columns. Two modules may use one name for different columns, and
with a wrong column a kernel computes wrong numbers without an error."""


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def imports(path: Path) -> tuple[ast.ImportFrom, ...]:
    """All `from … import` statements of a file, also those in functions."""
    tree = ast.parse(text_of(path))
    return tuple(node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom))


def bare_columns(path: Path, module: str) -> list[str]:
    """Columns of a module that a file imports by name, without the module."""
    if module not in text_of(
        path
    ):  # true for most files, and parsing all of them would take seconds
        return []
    columns = {
        name
        for name, value in vars(import_module(module)).items()
        if name.isupper() and type(value) is int
    }
    names = [alias.name for node in imports(path) if node.module == module for alias in node.names]
    return [name for name in names if name in columns]


@pytest.mark.parametrize("module", COLUMN_MODULES)
def test_no_column_is_imported_without_its_module(module: str) -> None:
    found = {
        path.relative_to(ROOT).as_posix(): names
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*.py")
        if (names := bare_columns(path, module))
    }
    assert found == {}


def test_a_bare_column_is_seen_and_what_is_no_column_is_not(tmp_path: Path) -> None:
    file = tmp_path / "kernel.py"
    file.write_text(
        "from engine.physics.surface import LENGTH, touch\nfrom engine.physics import surface"
    )
    assert bare_columns(file, "engine.physics.surface") == ["LENGTH"]
    assert bare_columns(file, "engine.physics.body") == []
