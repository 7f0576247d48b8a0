"""The numbers of arrays' columns are reached through their modules: `layout.LENGTH`."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "benchmarks", "engine", "tests")

COLUMN_MODULES = (
    "engine.exact.event_log",
    "engine.exact.initial_state",
    "engine.exact.lockstep.lanes",
    "engine.exact.lockstep.search",
    "engine.exact.sensitivity",
    "engine.physics.body",
    "engine.physics.contact",
    "engine.physics.surface",
    "engine.physics.tangent",
)
"""Modules whose constants of type int are columns: two of them may give one name to two columns,
and of a wrong one a kernel makes numbers, not an error."""


def bare_columns(source: str, module: str) -> list[str]:
    """Columns of a module that a source text imports by name, without the module."""
    columns = {
        name
        for name, value in vars(import_module(module)).items()
        if name.isupper() and type(value) is int
    }
    return [
        alias.name
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.ImportFrom) and node.module == module
        for alias in node.names
        if alias.name in columns
    ]


@pytest.mark.parametrize("module", COLUMN_MODULES)
def test_no_column_is_imported_without_its_module(module: str) -> None:
    found = {
        path.relative_to(ROOT).as_posix(): names
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*.py")
        if (names := bare_columns(path.read_text(), module))
    }
    assert found == {}


def test_a_bare_column_is_seen_and_what_is_no_column_is_not() -> None:
    source = "from engine.physics.surface import LENGTH, touch\nfrom engine.physics import surface"
    assert bare_columns(source, "engine.physics.surface") == ["LENGTH"]
    assert bare_columns(source, "engine.physics.body") == []
