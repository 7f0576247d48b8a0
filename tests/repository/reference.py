"""docs/python-reference.md, of signatures and docstrings: `python -m tests.repository.reference`.

For whoever reads the repository, or has no browser: the site makes the same of docs/python.md.
"""

import ast
import inspect
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import plinko

PAGE = Path(__file__).parents[2] / "docs" / "python-reference.md"

GROUPS = {
    "Boards": ["Board", "BallSpec", "Material", "Peg", "Wall", "Bins", "Label", "DropZone",
               "polygon", "preset_names"],
    "Drops": ["drop", "Drop", "drop_many", "DropBatch", "occupancy", "Occupancy",
              "seeds_landing_in", "find_draw"],
    "Proofs and records": ["certify", "Certificate", "verify", "Verification"],
    "Live worlds": ["World", "Arena", "ArenaSettings", "Place"],
    "Pictures": list(plinko.PICTURES),
    "Errors": ["EngineError", "BoardError", "Fault", "SeedError", "ParameterError", "RecordError"],
    "Versions": ["PHYSICS_VERSION", "__version__"],
}  # fmt: skip
"""All names of `plinko`, in the order in which one meets them."""

_HEAD = """\
# The Python reference

Every public name with its signature, as a file; [the Python interface](python.md) introduces them.
`import plinko` has all of them. Made of the sources by `make readme`; a test compares it.
"""


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
        return _section("###", f"{name}{_arguments(node)}", ast.get_docstring(node))
    return f"### {name}\n\n`{value!r}`\n"


def _class(name: str, value: type) -> str:
    node = _node(value)
    bases = f"({ast.unparse(node.bases[0])})" if node.bases and "Error" in name else ""
    parts = [_section("###", f"class {name}{bases}", ast.get_docstring(node))]
    fields = [line for kind in _ours(value) for line in _fields(_node(kind))]
    if fields:
        parts.append("```text\n" + "\n".join(dict.fromkeys(fields)) + "\n```\n")
    seen: set[str] = set()
    for kind in _ours(value):
        for member in _members(_node(kind)):
            if member.name not in seen:
                seen.add(member.name)
                parts.append(_member(name, member))
    return "\n".join(parts)


def _ours(value: type) -> Iterator[type]:
    """The class and its bases in the engine, the class first."""
    return (kind for kind in value.__mro__ if kind.__module__.startswith("engine."))


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


def _member(owner: str, node: ast.FunctionDef) -> str:
    kinds = _decorators(node)
    if kinds & {"property", "cached_property"}:
        signature = f"{owner}.{node.name} -> {ast.unparse(node.returns) if node.returns else ''}"
    else:
        if "staticmethod" not in kinds:
            node.args.args = node.args.args[1:]
        signature = f"{owner}.{node.name}{_arguments(node)}"
    return _section("####", signature, ast.get_docstring(node))


def _decorators(node: ast.FunctionDef) -> set[str]:
    return {ast.unparse(each).rpartition(".")[2] for each in node.decorator_list}


def _arguments(node: Any) -> str:
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"({ast.unparse(node.args)}){returns}"


def _section(level: str, signature: str, words: str | None) -> str:
    title = signature.partition("(")[0].removeprefix("class ").partition(" ")[0]
    return f"{level} {title}\n\n```text\n{signature}\n```\n" + (f"\n{words}\n" if words else "")


def _node(value: Any) -> Any:
    return ast.parse(textwrap.dedent(inspect.getsource(value))).body[0]


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
