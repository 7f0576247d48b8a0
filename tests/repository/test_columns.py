"""The numbers of array columns are used with their module, such as `layout.LENGTH`."""

import ast
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "benchmarks", "engine", "tests")

COLUMN_MODULES = (
    "plinko.engine.exact.event_log",
    "plinko.engine.exact.initial_state",
    "plinko.engine.exact.lanes.flight",
    "plinko.engine.exact.lanes.impact",
    "plinko.engine.exact.lanes.lane",
    "plinko.engine.exact.lanes.search",
    "plinko.engine.exact.sensitivity",
    "plinko.engine.multibody.solver.layout.body",
    "plinko.engine.multibody.solver.layout.contact",
    "plinko.engine.multibody.solver.layout.hash_grid",
    "plinko.engine.multibody.solver.layout.pair",
    "plinko.engine.multibody.solver.layout.shape",
    "plinko.engine.multibody.solver.layout.step_log",
    "plinko.engine.multibody.solver.layout.sweep",
    "plinko.engine.physics.body",
    "plinko.engine.physics.contact",
    "plinko.engine.physics.surface",
    "plinko.engine.physics.tangent",
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
