"""Draws the picture in docs/architecture.md from the import contract: `make architecture`.

Each `layers` contract of pyproject.toml is a stack of rows: a module may import every module in the
rows below, and none in its own row or above. The text of a box is the first paragraph of the
module's docstring.
"""

import ast
import textwrap
import tomllib
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "images" / "architecture.svg"

WIDTH = 1160  # px, as all below
MARGIN = 20
GAP = 8
HEAD = 40  # height of a stack's title, above its first row
LINE = 15
FONT = 12.5
LETTER = 0.56 * FONT  # mean width of a letter, estimated high
MOST = 4  # boxes side by side; a longer row is drawn in several lines, close to each other
CLOSE = 3  # between these lines


@dataclass(frozen=True)
class Stack:
    """A package whose parts are in layers, from top to bottom."""

    package: str
    layers: tuple[tuple[str, ...], ...]


def stacks() -> list[Stack]:
    """The packages with an exhaustive contract: the server, then the engine."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    found = {}
    for contract in project["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers" and contract["containers"][0].count(".") == 1:
            package = contract["containers"][0].removeprefix("plinko.")
            rows = (tuple(part.strip() for part in row.split("|")) for row in contract["layers"])
            found[package] = Stack(package, tuple(rows))
    return [found["app"], found["engine"]]


def sentence(package: str, part: str) -> str:
    """The first paragraph of the docstring of a module or package."""
    base = ROOT / package / part
    path = base / "__init__.py" if base.is_dir() else base.with_suffix(".py")
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())


def draw() -> str:
    """The drawing as SVG."""
    parts: list[str] = []
    y = _bar(parts, MARGIN, "static", "The pages: they use the server only by REST and WebSocket.")
    y = _bar(
        parts, y, "benchmarks", "Measurements of speed and error: may import everything below."
    )
    left, right = stacks()
    width = (WIDTH - 2 * MARGIN - 3 * GAP) / 2
    bottom = max(
        _stack(parts, MARGIN, y, width, left, "#dce9f9", "imports the engine too"),
        _stack(parts, WIDTH - MARGIN - width, y, width, right, "#e3f1dc", "imports no server"),
    )
    height = bottom + MARGIN
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
        f'height="{height}" font-family="system-ui, sans-serif" font-size="15" fill="#1d2430">\n'
        f"<title>The packages: each may import the packages below it in its stack</title>\n"
        f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>\n{body}\n</svg>\n'
    )


def _bar(parts: list[str], y: float, name: str, says: str) -> float:
    height = _height([says], WIDTH - 2 * MARGIN)
    _box(parts, (MARGIN, y, WIDTH - 2 * MARGIN, height), name, says, "#eef1f5")
    return y + height + GAP


def _stack(
    parts: list[str], x: float, y: float, width: float, stack: Stack, fill: str, note: str
) -> float:
    """Draw a stack with its upper left corner at (x, y); returns where it ends."""
    frame = len(parts)
    top = y + HEAD
    inner = width - 2 * 12
    for row in stack.layers:
        lines = -(-len(row) // MOST)
        in_line = -(-len(row) // lines)
        gap = GAP if lines == 1 else CLOSE
        each = (inner - gap * (in_line - 1)) / in_line
        for first in range(0, len(row), in_line):
            names = row[first : first + in_line]
            says = [sentence(stack.package, part) for part in names]
            height = _height(says, each)
            for place, (part, text) in enumerate(zip(names, says, strict=True)):
                left = x + 12 + place * (each + gap)
                _box(parts, (left, top, each, height), part, text, fill)
            top += height + gap
        top += GAP - gap
    bottom = top + 4
    parts.insert(
        frame,
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{bottom - y:g}" rx="10" '
        f'fill="none" stroke="#8894a6"/>\n'
        f'<text x="{x + 14:g}" y="{y + 26:g}" font-weight="700">{stack.package}</text>\n'
        f'<text x="{x + width - 14:g}" y="{y + 26:g}" text-anchor="end" font-size="{FONT}">'
        f"↓ each row may import the rows below it; {note}</text>",
    )
    return bottom


def _wrapped(says: str, width: float) -> list[str]:
    return textwrap.wrap(says.replace("`", ""), int((width - 20) / LETTER))


def _height(says: list[str], width: float) -> float:
    return 34 + LINE * max(len(_wrapped(each, width)) for each in says)


def _box(
    parts: list[str], where: tuple[float, float, float, float], name: str, says: str, fill: str
) -> None:
    x, y, width, height = where
    parts.append(
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="{fill}" '
        f'stroke="#8894a6"/>\n'
        f'<text x="{x + 10:g}" y="{y + 20:g}" font-weight="600">{escape(name)}</text>'
    )
    for number, line in enumerate(_wrapped(says, width)):
        parts.append(
            f'<text x="{x + 10:g}" y="{y + 37 + LINE * number:g}" font-size="{FONT}">'
            f"{escape(line)}</text>"
        )


if __name__ == "__main__":
    PICTURE.write_text(draw(), encoding="utf-8")
