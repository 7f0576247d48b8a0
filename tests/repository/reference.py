"""Writes docs/python-reference.md from the sources: `python -m tests.repository.reference`.

The page is for readers of the repository: each name with its arguments and the beginning of its
docstring. The site has types and whole docstrings, from docs/python.md, which also lists the
members of classes to show.
"""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import plinko

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "python-reference.md"

GROUPS = {
    "Boards": ["Board", "BallSpec", "Material", "Peg", "Wall", "Bins", "Label", "DropZone",
               "polygon", "preset_names"],
    "Drops": ["drop", "Drop", "Trajectory", "Certainty", "Solver", "drop_many", "DropBatch",
              "concat", "sweep", "occupancy", "Occupancy", "seeds_landing_in", "find_draw"],
    "Proofs and records": ["certify", "Certificate", "verify", "Verification"],
    "Live worlds": ["World", "Arena", "ArenaSettings", "StaticGeometry"],
    "Pictures": list(plinko.PICTURES),
    "Errors": ["PlinkoError", "BoardError", "Fault", "SeedError", "ParameterError", "RecordError",
               "EffortError", "JsonSyntaxError", "JsonValueError", "InvalidValueError",
               "MissingPartError", "ClusterError"],
    "Versions": ["PHYSICS_VERSION", "__version__"],
}  # fmt: skip
"""All names of `plinko`, in the order of the page."""

_HEAD = """\
# The Python reference

For Python programmers: every public name of `plinko` in one list.

[The Python interface](python.md) introduces the names; `help(plinko.Board)` prints types and
docstrings. `make readme` makes this page from the sources.
"""


SHOWN = {
    name: members.split(", ")
    for name, members in re.findall(
        r"^\.\. autoclass:: plinko\.(\w+)\n   :members: (.+)$",
        (DOCS / "python.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
}
"""By class, the members that docs/python.md lists; of other classes, all members are shown."""


def text() -> str:
    """The page."""
    parts = [_HEAD]
    for title, names in GROUPS.items():
        parts.append(f"## {title}\n")
        parts += [_entry(name, getattr(plinko, name)) for name in names]
    return "\n".join(parts)


def _entry(name: str, value: Any) -> str:
    if inspect.isclass(value):
        return _class(name, value)
    if inspect.isfunction(value):
        node = _node(value)
        return _section(name, _summary(node), [f"{name}{_arguments(node)}"])
    return f"### {name}\n\n`{value!r}`\n"


def _class(name: str, value: type) -> str:
    node = _node(value)
    bases = f"({', '.join(map(_public, value.__bases__))})" if "Error" in name else ""
    lines = [f"class {name}{bases}"]
    lines += dict.fromkeys(f"    {line}" for kind in _ours(value) for line in _fields(_node(kind)))
    members: dict[str, ast.FunctionDef] = {}
    for kind in _ours(value):
        for member in _members(_node(kind)):
            members.setdefault(member.name, member)
    for member in members.values():
        if member.name not in SHOWN.get(name, members):
            continue
        lines += [f"    {_signature(member)}", *(f"        {line}" for line in _first_line(member))]
    return _section(name, _summary(node), lines)


def _public(kind: type) -> str:
    """Name of the class, or of its first base that is public or Python's own."""
    while kind.__name__ not in plinko.__all__ and kind.__module__ != "builtins":
        kind = kind.__bases__[0]
    return kind.__name__


def _ours(value: type) -> Iterator[type]:
    """The class and then its bases that belong to the engine."""
    return (kind for kind in value.__mro__ if kind.__module__.startswith("plinko.engine."))


def _fields(node: ast.ClassDef) -> Iterator[str]:
    for item in node.body:
        if isinstance(item, ast.AnnAssign) and not ast.unparse(item.target).startswith("_"):
            yield f"{ast.unparse(item.target)}: {ast.unparse(item.annotation)}" + _default(item)


def _default(item: ast.AnnAssign) -> str:
    if item.value is None or (
        isinstance(item.value, ast.Call) and "init" in ast.unparse(item.value)
    ):
        return ""
    if isinstance(item.value, ast.Call) and "default_factory" in ast.unparse(item.value):
        return f" = {ast.unparse(item.value.keywords[0].value)}()"
    return f" = {ast.unparse(item.value)}"


def _members(node: ast.ClassDef) -> Iterator[ast.FunctionDef]:
    for item in node.body:
        if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
            yield item


def _signature(node: ast.FunctionDef) -> str:
    kinds = _decorators(node)
    if kinds & {"property", "cached_property"}:
        return f"{node.name} -> {ast.unparse(node.returns) if node.returns else ''}"
    if "staticmethod" not in kinds:
        node.args.args = node.args.args[1:]
    return f"{node.name}{_arguments(node)}"


def _summary(node: Any) -> str:
    """The first paragraph of the docstring."""
    return (ast.get_docstring(node) or "").partition("\n\n")[0]


def _first_line(node: ast.FunctionDef) -> list[str]:
    return (ast.get_docstring(node) or "").splitlines()[:1]


def _decorators(node: ast.FunctionDef) -> set[str]:
    return {ast.unparse(each).rpartition(".")[2] for each in node.decorator_list}


def _arguments(node: Any) -> str:
    """Names and defaults of the arguments, and the type of the result, if there is one."""
    arguments = node.args
    for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
        each.annotation = None
    for each in filter(None, (arguments.vararg, arguments.kwarg)):
        each.annotation = None
    result = ast.unparse(node.returns) if node.returns else "None"
    return f"({ast.unparse(arguments)})" + (f" -> {result}" if result != "None" else "")


def _section(name: str, words: str, lines: list[str]) -> str:
    code = "\n".join(lines)
    return f"### {name}\n\n" + (f"{words}\n\n" if words else "") + f"```text\n{code}\n```\n"


def _node(value: Any) -> Any:
    return ast.parse(textwrap.dedent(inspect.getsource(value))).body[0]


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
