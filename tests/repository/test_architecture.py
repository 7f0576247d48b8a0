"""docs/architecture.md is true: its drawing shows the import contract, and what it names exists."""

import ast
import re
from pathlib import Path

import pytest

from tools.architecture import PICTURE, ROOT, draw, stacks

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
NAMED = sorted(
    set(re.findall(r"`((?:app|engine|static|tests|benchmarks|deploy|docs|tools)/[^`\s]*)`", PAGE))
)


def test_the_drawing_is_made_of_the_import_contract_as_it_stands() -> None:
    assert draw() == PICTURE.read_text(encoding="utf-8"), "`make architecture` draws it again"
    assert f"(images/{PICTURE.name})" in PAGE


def test_every_package_of_engine_and_server_is_in_the_drawing() -> None:
    for stack in stacks():
        folder = ROOT / stack.package
        parts = {path.stem for path in folder.iterdir() if path.suffix == ".py" or path.is_dir()}
        assert parts - {"__init__", "__pycache__"} == {part for row in stack.layers for part in row}


def test_every_part_of_engine_and_server_is_on_the_page() -> None:
    folders = {
        f"{top}/{path.name}/"
        for top in ("app", "engine")
        for path in (ROOT / top).iterdir()
        if (path / "__init__.py").exists()
    }
    assert folders <= set(NAMED)


def definitions(path: Path) -> set[str]:
    """Names that a Python file defines (members as Class.name); all words of other files."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return set(re.findall(r"\w+", text))
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ClassDef):
            inside = [
                each
                for each in node.body
                if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)
            ]
            found |= {node.name, *(f"{node.name}.{each.name}" for each in inside)}
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found.add(node.name)
    return found


@pytest.mark.parametrize("named", NAMED)
def test_what_the_page_names_is_there(named: str) -> None:
    file, _, name = named.partition(":")
    path = ROOT / file
    assert path.exists(), file
    if name:
        assert name in definitions(path), f"{file} defines no {name}"
