"""The files in docs/measured, one for each benchmark: how they are written, read and shown."""

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchmarks.harness.effort import MissingError
from benchmarks.harness.report import Section, Table

DOCS: Final = Path(__file__).parents[2] / "docs"
FOLDER: Final = DOCS / "measured"
IMAGES: Final = DOCS / "images"

_NUMBER = re.compile(r"[+-]?[\d,]+(\.\d+)?(e[+-]?\d+)?")
_LIST = re.compile(r"\[\n\s+([^][{}]*?)\n\s+\]")


def write(section: Section, machine: dict[str, str], seconds: float, folder: Path) -> None:
    """Replace the file of a benchmark, and its plots."""
    for name, plot in section.plots.items():
        IMAGES.mkdir(parents=True, exist_ok=True)
        plot(str(IMAGES / name))
    about = {"seconds": round(seconds), "machine": machine, "plots": list(section.plots)}
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{section.name}.json"
    path.write_text(text_of(about | section.to_dict()), encoding="utf-8")


def text_of(record: dict[str, Any]) -> str:
    """A record as JSON with a line for each row of a table; the numbers of plots stay out."""
    kept = {name: value for name, value in record.items() if name != "data"}
    text = json.dumps(kept, indent=1, ensure_ascii=False)
    return _LIST.sub(lambda row: "[" + re.sub(r"\n\s+", " ", row[1]) + "]", text) + "\n"


def read(folder: Path = FOLDER) -> "Recorded":
    """All recorded files together."""
    return tables_of(sorted(folder.glob("*.json")))


def tables_of(paths: Iterable[Path]) -> "Recorded":
    """The tables of these files; a file that does not exist has none."""
    records = [json.loads(path.read_text(encoding="utf-8")) for path in paths if path.exists()]
    return Recorded(tuple(Table(**table) for record in records for table in record["tables"]))


def site_text(folder: Path = FOLDER) -> str:
    """All records in Markdown, for the page of the site that shows them."""
    parts = []
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        parts.append(f"## {path.stem}")
        if machine := record.get("machine"):
            took = f" in {record['seconds']:,} s" if record["seconds"] else ""
            about = ", ".join(f"{name} {value}" for name, value in machine.items())
            parts.append(f"By `python -m benchmarks {path.stem}`{took}, on: {about}.")
        parts += [f"#{Table(**table).text()}" for table in record["tables"]]
        parts += [f"- Not taking part: {line}" for line in record["absent"]]
        parts += [f"![{_words(name)}](images/{name})" for name in record["plots"]]
    return "\n\n".join(parts)


def _words(plot: str) -> str:
    return Path(plot).stem.removeprefix("bench-").replace("-", " ")


@dataclass(frozen=True)
class Recorded:
    """The tables of one file or several; each table has a different title."""

    tables: tuple[Table, ...]

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
        return self._table(title) is not None

    def rows(self, title: str) -> list[dict[str, str]]:
        """The rows of a table, each cell by its column's name; empty if no table matches."""
        table = self._table(title)
        return [dict(zip(table.columns, row, strict=True)) for row in table.rows] if table else []

    def title(self, begin: str) -> str:
        """The full title that starts with `begin`."""
        table = self._table(begin)
        return table.title if table else begin

    def _table(self, begin: str) -> Table | None:
        return next((table for table in self.tables if table.title.startswith(begin)), None)
