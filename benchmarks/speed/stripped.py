"""The engine as if it had never had a feature: a copy with the feature cut out of its code.

The copy is made from the source by replacing what the feature is switched by with a constant, as if
the switch did not exist; the compiler then removes all that hangs on it. It lives in a package of
its own name, so that both engines run in one process, in turns, and on the same boards their
outcomes must be equal to the last bit.
"""

import ast
import importlib
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import engine

SOURCE = Path(engine.__file__).parent


_IMPORTED = re.compile(r"^( *from )engine(?=[. ])", re.MULTILINE)
_WHOLE = re.compile(r"^ *import engine\b.*", re.MULTILINE)
_NAMED = re.compile(r"^class (\w+)\(NamedTuple\):$", re.MULTILINE)


def _renamed(text: str, package: str) -> str:
    """Imports of the engine become imports of the copy, and its named tuples have other names.

    Numba tells the types of arguments quickly by the names of their classes. Of two classes of one
    name only the first has the quick way; the other's calls would each take 0.4 ms.
    """
    whole = _WHOLE.search(text)
    if whole:
        raise ValueError(f"`{whole[0].strip()}` cannot be renamed, and the engine has no such line")
    names = [f"{name}.__name__ = '{name}_of_{package}'\n" for name in _NAMED.findall(text)]
    return _IMPORTED.sub(rf"\1{package}", text) + "".join(names)


class _Cut(ast.NodeTransformer):
    """Counts its replacements: a cut that replaces nothing has lost touch with the engine."""

    done = 0
    least = 1
    """Replacements without which the feature is not gone."""

    places: tuple[str, ...] = ("physics", "exact", "stepped", "multibody/solver")
    """Files and folders of the engine that are cut; the rest only has its imports renamed."""

    def put(self, value: float | bool, old: ast.expr) -> ast.expr:
        """A constant in place of `old`."""
        self.done += 1
        return ast.copy_location(ast.Constant(value), old)


class _Zero(_Cut):
    """Fields of the board, parameters and functions that become 0.0."""

    def __init__(self, fields: set[str], parameters: set[str], functions: set[str]) -> None:
        self.fields, self.parameters, self.functions = fields, parameters, functions

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """board.drag."""
        of_board = isinstance(node.value, ast.Name) and node.value.id == "board"
        return self.put(0.0, node) if of_board and node.attr in self.fields else node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """friction_of(board, item)."""
        self.generic_visit(node)
        named = isinstance(node.func, ast.Name) and node.func.id in self.functions
        return self.put(0.0, node) if named else node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        """A parameter is overwritten at the top of its function: to a compiler the same."""
        self.generic_visit(node)
        for argument in node.args.args:
            if argument.arg in self.parameters:
                self.done += 1
                line = ast.parse(f"{argument.arg} = 0.0").body[0]
                node.body.insert(1 if ast.get_docstring(node) else 0, line)
        return node


class _NoWalls(_Cut):
    """Every surface is a circle, and a peg."""

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        """surface[DISTANCE] > 0.0, and item < board.peg_count."""
        self.generic_visit(node)
        left, right, how = node.left, node.comparators[0], node.ops[0]
        if isinstance(left, ast.Subscript) and ast.unparse(left.slice).endswith("DISTANCE"):
            return self.put(isinstance(how, ast.Gt), node)
        if ast.unparse(right) == "board.peg_count":
            return self.put(isinstance(how, ast.Lt), node)
        return node


class _NoLog(_Cut):
    """Events are counted, as a batch needs, and nothing is written down."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        """The two functions that write."""
        bodies = {
            "note_event": "log.counts[EVENTS] = log.counts[EVENTS] + 1",
            "note_segment": "pass",
        }
        if node.name in bodies:
            self.done += 1
            node.body = ast.parse(bodies[node.name]).body
        return node


class _NoDiagnostics(_Cut):
    """Arenas that cannot be asked for energies and contacts."""

    places = ("multibody/arena.py",)
    least = 2

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef | None:
        """Arena.diagnostics."""
        self.generic_visit(node)
        if node.name == "diagnostics":
            self.done += 1
            return None
        return node

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.ImportFrom | None:
        """What computes them."""
        if (node.module or "").endswith("multibody.diagnostics"):
            self.done += 1
            return None
        return node


class _Nothing(_Cut):
    """The control: a copy with all its features."""

    done = 1


CUTS: dict[str, Callable[[], _Cut]] = {
    "nothing": _Nothing,
    "drag": lambda: _Zero({"drag"}, {"k", "drag"}, set()),
    "friction": lambda: _Zero({"peg_friction", "wall_friction"}, {"friction"}, {"friction_of"}),
    "walls": _NoWalls,
    "recording": _NoLog,
    "diagnostics": _NoDiagnostics,
}


class LostTouchError(Exception):
    """The engine's source no longer holds what a cut replaces."""


@contextmanager
def without(feature: str) -> Iterator[ModuleType]:
    """The engine without one of CUTS, as a package with the engine's own interface."""
    package = f"engine_without_{feature.replace('-', '_').replace(' ', '_')}"
    with tempfile.TemporaryDirectory() as folder:
        copy(package, CUTS[feature](), Path(folder))
        sys.path.insert(0, folder)
        try:
            yield importlib.import_module(package)
        finally:
            sys.path.remove(folder)
            for name in [name for name in sys.modules if name.split(".")[0] == package]:
                del sys.modules[name]


def copy(package: str, cut: _Cut, folder: Path) -> None:
    """Write the cut copy into a folder; LostTouchError if there was nothing to cut."""
    target = folder / package
    shutil.copytree(SOURCE, target, ignore=shutil.ignore_patterns("__pycache__", "artifact"))
    for path in target.rglob("*.py"):
        text = _renamed(path.read_text(), package)
        if path.relative_to(target).as_posix().startswith(cut.places):
            text = ast.unparse(cut.visit(ast.parse(text)))
        path.write_text(text)
    if cut.done < cut.least:
        raise LostTouchError(
            f"{cut.done} of {cut.least} to cut for {package}: its switch has another name now"
        )
