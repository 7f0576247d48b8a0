"""The files in docs/measured, one for each benchmark: how they are written and read."""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.harness.effort import MissingError
from benchmarks.harness.report import Section

DOCS: Final = Path(__file__).parents[2] / "docs"
FOLDER: Final = DOCS / "measured"
IMAGES: Final = DOCS / "images"

_NUMBER = re.compile(r"[+-]?[\d,]+(\.\d+)?(e[+-]?\d+)?")


def write(section: Section, machine: dict[str, str], seconds: float, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, plot in section.plots.items():
        IMAGES.mkdir(parents=True, exist_ok=True)
        plot(str(IMAGES / name))
    pictures = os.path.relpath(IMAGES, folder)
    about = ", ".join(f"{name} {value}" for name, value in machine.items())
    plots = (f"![{_words(name)}]({pictures}/{name})" for name in section.plots)
    parts = [
        f"# Measured: {section.name}",
        f"By `python -m benchmarks {section.name}` in {seconds:,.0f} s, on: {about}.",
        section.text(),
        *plots,
    ]
    (folder / f"{section.name}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _words(plot: str) -> str:
    return Path(plot).stem.removeprefix("bench-").replace("-", " ")


def read(folder: Path = FOLDER) -> "Recorded":
    """All recorded files together."""
    texts = (path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.md")))
    return Recorded("\n".join(texts))


@dataclass(frozen=True)
class Recorded:
    """The tables of one file or several; each table has a different title."""

    text: str

    def number(self, title: str, row: str, column: str) -> float:
        """The number at the beginning of a cell; raises MissingError if it has no number."""
        for cells in self.rows(title):
            if next(iter(cells.values())) != row:
                continue
            cell = cells.get(column, "")
            found = _NUMBER.match(cell)
            if found:
                return float(found[0].replace(",", "")) * (0.01 if cell.endswith("%") else 1.0)
        raise MissingError(f"no file records {column!r} of {row!r} under {title!r}")

    def has(self, title: str) -> bool:
        """Whether any table's title begins with `title`."""
        return bool(self._lines(title))

    def rows(self, title: str) -> list[dict[str, str]]:
        """The rows of a table, each cell by its column's name; empty if no table matches."""
        header, _, *body = map(_cells, self._lines(title) or ["", ""])
        return [dict(zip(header, cells, strict=True)) for cells in body]

    def title(self, begin: str) -> str:
        """The full title that starts with `begin`."""
        _, _, rest = self.text.partition(f"\n## {begin}")
        return begin + rest.partition("\n")[0]

    def _lines(self, title: str) -> list[str]:
        """The lines of the table under the first heading that begins with `title`, if any."""
        _, found, rest = self.text.partition(f"\n## {title}")
        lines: list[str] = []
        for line in rest.splitlines() if found else ():
            if line.startswith("|"):
                lines.append(line)
            elif lines or line.startswith("#"):
                break
        return lines


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]
