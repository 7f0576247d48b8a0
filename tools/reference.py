"""The Python reference, made from the sources: the site shows it in docs/python-reference.md.

Each name has its arguments with types and defaults, its members, and their docstrings.
"""

import ast
import inspect
import itertools
import re
import sys
import textwrap
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import plinko

WIDTH = 96

GROUPS = {
    "Boards": ["Board", "BallSpec", "Material", "Peg", "Wall", "Bins", "Label", "DropZone",
               "polygon", "preset_names", "engine.board.payouts.Risk"],
    "Drops": ["drop", "Drop", "engine.drops.trajectory.IMPACT", "engine.drops.drop.STATE",
              "Trajectory", "Certainty", "Solver", "engine.parameters.SolverName", "drop_many",
              "engine.drops.batch.Seeds", "DropBatch", "concat", "sweep", "occupancy",
              "Occupancy", "seeds_landing_in", "find_draw"],
    "Proofs and records": ["certify", "Certificate", "verify", "Verification"],
    "Long batches": ["engine.batches.job.Job", "engine.batches.block.block_of",
                     "engine.batches.block.Block", "engine.batches.tally.Tally",
                     "engine.batches.workers.workers_at", "engine.batches.workers.Workers"],
    "Payouts": ["engine.payouts.solve.solve_payouts", "engine.payouts.solve.Payouts",
                "engine.payouts.record.odds_of_record", "engine.payouts.odds.odds_of",
                "engine.payouts.odds.Odds", "engine.payouts.landings.Landings"],
    "Live worlds": ["World", "engine.world.world.Energy", "engine.world.world.Momentum", "Arena",
                    "ArenaSettings", "StaticGeometry", "engine.multibody.scenes.sandbox",
                    "engine.multibody.scenes.galton", "engine.multibody.scenes.on_board"],
    "Pictures": list(plinko.PICTURES),
    "Errors": ["PlinkoError", "BoardError", "Fault", "SeedError", "ParameterError", "RecordError",
               "EffortError", "JsonSyntaxError", "JsonValueError", "InvalidValueError",
               "MissingPartError", "ClusterError"],
    "Versions": ["PHYSICS_VERSION", "__version__"],
}  # fmt: skip
"""All names of `plinko` and some of its modules, in the order of the page."""

INTERNAL = {
    "Board": {"of", "kept", "is_kept"},
    "Certificate": {"event_rows"},
    "Drop": {"ticks"},
    "World": {"add_flight", "advance_to", "events_kept", "skip_ids"},
    "Arena": {"from_snapshot", "nbytes", "take_landings"},
    "ArenaSettings": {"changed", "for_solver"},
    "StaticGeometry": {"from_dict"},
    "Job": {"options", "to_dict"},
    "Tally": {"drops", "hash_of"},
    "Payouts": {"chosen_by", "warnings"},
}
"""By class, the members that only Plinko itself uses."""


def text() -> str:
    """All names in Markdown."""
    parts = []
    for title, names in GROUPS.items():
        parts.append(f"## {title}\n")
        parts += map(_entry, names)
    return re.sub(r"\bFloats\b", "npt.NDArray[np.float64]", "\n".join(parts))


def _entry(path: str) -> str:
    module, _, name = f"plinko.{path}".rpartition(".")
    value = getattr(import_module(module), name)
    shown = name if module == "plinko" else f"{module}.{name}"
    if inspect.isclass(value):
        return _section(shown, *_class(name, value))
    if inspect.isfunction(value):
        node = _node(value)
        return _section(shown, ast.get_docstring(node) or "", _call(name, node))
    return _section(shown, _words_after(name), [repr(value).replace("plinko.engine.", "")])


def _class(name: str, value: type) -> tuple[str, list[str]]:
    node = _node(value)
    bases = f"({', '.join(map(_public, value.__bases__))})" if "Error" in name else ""
    lines = [f"class {name}{bases}"]
    hidden = INTERNAL.get(name, set())
    fields: dict[str, list[str]] = {}
    methods: dict[str, list[str]] = {}
    for kind in _ours(value):
        body = _node(kind).body
        for item, after in zip(body, [*body[1:], None], strict=True):
            if isinstance(item, ast.FunctionDef):
                methods.setdefault(item.name, _member(item))
            elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
                field = f"{item.target.id}: {ast.unparse(item.annotation)}{_default(item)}"
                fields.setdefault(item.target.id, [field, *_indented(_string(after))])
    for member, shown in (fields | methods).items():
        if member == "__init__" or not (member.startswith("_") or member in hidden):
            lines += [f"    {line}".rstrip() for line in shown]
    return ast.get_docstring(node) or "", lines


def _public(kind: type) -> str:
    """Name of the class, or of its first base that is public or Python's own."""
    while kind.__name__ not in plinko.__all__ and kind.__module__ != "builtins":
        kind = kind.__bases__[0]
    return kind.__name__


def _ours(value: type) -> Iterator[type]:
    """The class and then its bases that belong to the engine."""
    return (kind for kind in value.__mro__ if kind.__module__.startswith("plinko.engine."))


def _default(item: ast.AnnAssign) -> str:
    if item.value is None or (
        isinstance(item.value, ast.Call) and "init" in ast.unparse(item.value)
    ):
        return ""
    if isinstance(item.value, ast.Call) and "default_factory" in ast.unparse(item.value):
        return f" = {ast.unparse(item.value.keywords[0].value)}()"
    return f" = {ast.unparse(item.value)}"


def _member(node: ast.FunctionDef) -> list[str]:
    words = _indented(ast.get_docstring(node) or "")
    kinds = {ast.unparse(each).rpartition(".")[2] for each in node.decorator_list}
    if kinds & {"property", "cached_property"}:
        return [f"{node.name}: {ast.unparse(node.returns) if node.returns else ''}", *words]
    if "staticmethod" not in kinds:
        node.args.args = node.args.args[1:]
    return [*_call(node.name, node), *words]


def _call(name: str, node: ast.FunctionDef) -> list[str]:
    """The signature, with an argument on each line if it is long."""
    result = ast.unparse(node.returns) if node.returns else "None"
    end = "" if result == "None" else f" -> {result}"
    line = f"{name}({ast.unparse(node.args)}){end}"
    if len(line) <= WIDTH:
        return [line]
    return [f"{name}(", *(f"    {each}," for each in _arguments(node.args)), f"){end}"]


def _arguments(node: ast.arguments) -> Iterator[str]:
    missing = [None] * (len(node.args) - len(node.defaults))
    for each, default in zip(node.args, [*missing, *node.defaults], strict=True):
        yield _argument(each, default)
    if node.vararg or node.kwonlyargs:
        yield "*" + (ast.unparse(node.vararg) if node.vararg else "")
    for each, default in zip(node.kwonlyargs, node.kw_defaults, strict=True):
        yield _argument(each, default)
    if node.kwarg:
        yield f"**{ast.unparse(node.kwarg)}"


def _argument(node: ast.arg, default: ast.expr | None) -> str:
    return ast.unparse(node) + (f" = {ast.unparse(default)}" if default else "")


def _words_after(name: str) -> str:
    """The string after the assignment to `name`, in whichever module defines it."""
    for module in [each for key, each in sys.modules.items() if key.startswith("plinko.engine")]:
        body = ast.parse(inspect.getsource(module)).body
        for item, after in itertools.pairwise(body):
            targets = item.targets if isinstance(item, ast.Assign) else []
            if isinstance(item, ast.AnnAssign):
                targets = [item.target]
            if name in map(ast.unparse, targets):
                return _string(after)
    return ""


def _string(node: ast.stmt | None) -> str:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return inspect.cleandoc(str(node.value.value))
    return ""


def _indented(words: str) -> list[str]:
    return [f"    {line}" for line in words.splitlines()]


def _section(name: str, words: str, lines: list[str]) -> str:
    code = "\n".join(lines)
    return f"### {name}\n\n" + (f"{words}\n\n" if words else "") + f"```text\n{code}\n```\n"


def _node(value: Any) -> Any:
    return ast.parse(textwrap.dedent(inspect.getsource(value))).body[0]
