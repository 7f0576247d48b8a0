"""Print how large the product and the tests are: `make size`.

Lines are all lines of committed files, blank ones and comments too. A file's fan-out is how many
other files of the repository it imports.
"""

import ast
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
PRODUCT: Final = ("app", "engine", "src", "static")
JS_CLASS: Final = re.compile(r"^\s*(?:export )?(?:default )?class \w", re.MULTILINE)
JS_FUNCTION: Final = re.compile(
    # function f(), a method, const f = () =>
    r"^\s*(?:export )?(?:default )?(?:async )?function\b"
    r"|^ {2,}(?:static |async |get |set |\*)*#?(?!if|for|while|switch|catch)\w+\([^()]*\) \{$"
    r"|^(?:export )?const \w+ = (?:async )?(?:\([^()]*\)|\w+) =>",
    re.MULTILINE,
)
JS_IMPORT: Final = re.compile(r"""(?:from|import\()\s*["'](\.[^"']+)["']""")


@dataclass
class Size:
    """Sums over files of one part of the repository."""

    lines: int = 0
    files: int = 0
    classes: int = 0
    functions: int = 0
    fan_out: dict[str, int] = field(default_factory=dict)


def main() -> None:
    """Print a row for each part and language, then the sums of product and tests."""
    print(f"{'':22}{'lines':>9}{'files':>8}{'classes':>9}{'functions':>11}  widest fan-out")
    for name, folders, suffixes in (
        ("app", ("app",), (".py",)),
        ("engine", ("engine",), (".py",)),
        ("pages", ("static",), (".js", ".css", ".html")),
        ("product", PRODUCT, (".py", ".js", ".css", ".html")),
        ("tests", ("tests",), (".py", ".js", ".mjs")),
    ):
        size = measured(files(folders, suffixes))
        path, most = max(size.fan_out.items(), key=lambda each: each[1])
        print(
            f"{name:22}{size.lines:>9,}{size.files:>8,}{size.classes:>9,}{size.functions:>11,}"
            f"  {most} {path}"
        )


def files(folders: tuple[str, ...], suffixes: tuple[str, ...]) -> Iterator[Path]:
    """All committed files in these folders; links are not followed."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", *folders], cwd=ROOT, capture_output=True, text=True, check=True
    )
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.suffix in suffixes and path.is_file() and not path.is_symlink():
            yield path


def measured(paths: Iterator[Path]) -> Size:
    """The sums of these files."""
    size = Size()
    for path in paths:
        text = path.read_text(encoding="utf-8")
        size.files += 1
        size.lines += text.count("\n")
        if path.suffix == ".py":
            nodes = list(ast.walk(ast.parse(text)))
            size.classes += sum(isinstance(each, ast.ClassDef) for each in nodes)
            size.functions += sum(
                isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef) for each in nodes
            )
            imported = len(set(python_imports(nodes)))
        else:
            size.classes += len(JS_CLASS.findall(text))
            size.functions += len(JS_FUNCTION.findall(text))
            imported = len(set(JS_IMPORT.findall(text)))
        size.fan_out[str(path.relative_to(ROOT))] = imported
    return size


def python_imports(nodes: list[ast.AST]) -> Iterator[str]:
    """The modules of the repository that a file imports."""
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module:
            if node.module.split(".")[0] in {"plinko", "benchmarks", "tests"}:
                yield from module_names(node.module, [each.name for each in node.names])
        elif isinstance(node, ast.Import):
            yield from (e.name for e in node.names if e.name.startswith(("plinko", "tests")))


def module_names(package: str, names: list[str]) -> Iterator[str]:
    """`package` itself, or those of its modules that are imported by name."""
    folder = ROOT / package.replace(".", "/")
    modules = [n for n in names if (folder / f"{n}.py").is_file() or (folder / n).is_dir()]
    yield from (f"{package}.{name}" for name in modules)
    if len(modules) < len(names):
        yield package


if __name__ == "__main__":
    main()
