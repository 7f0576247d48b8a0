"""Copies recorded tables into the pages that show them, between comments that name the table.

    <!-- table accuracy: Error against the oracle | rows: plinko exact; Chipmunk 1/240 -->
    <!-- /table -->

names a file of docs/measured and a table in it, by its title or the beginning of its title. A page
that does not show the whole table lists rows, by their first cells, and columns other than the
first. The file `estimates` has what docs/growing.md extrapolates from the others.
"""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.harness.effort import MissingError
from benchmarks.harness.recorded import DOCS, FOLDER, read, tables_of, text_of
from benchmarks.harness.report import Section, Table
from benchmarks.scale.estimates import tables, units_of

README: Final = DOCS.parent / "README.md"
ESTIMATES: Final = FOLDER / "estimates.json"

_TABLE = re.compile(
    r"(<!-- table ([\w-]+): ([^|]*?)((?: \| .*?)?) -->\n).*?(<!-- /table -->)", re.DOTALL
)
_SPREAD = re.compile(r" \([^()]* to [^()]*\)$")
"""The spread in a cell, which a file shows after the median and a page does not."""


def fill_all() -> list[Path]:
    """Fill the README and every page in docs; returns the pages that have changed."""
    ESTIMATES.write_text(estimates(), encoding="utf-8")
    changed = []
    for page in (README, *sorted(DOCS.glob("*.md"))):
        old = page.read_text(encoding="utf-8")
        new = filled(old, page.parent)
        if new != old:
            page.write_text(new, encoding="utf-8")
            changed.append(page)
    return changed


def estimates() -> str:
    """The text of the file `estimates`."""
    section = Section("estimates", tables(units_of(read())))
    return text_of({"plots": []} | section.to_dict())


def filled(text: str, place: Path, folder: Path = FOLDER) -> str:
    """Fill the tables of a page that lies in the folder `place`.

    A table that is not recorded yet is replaced by the command that records it. Raises MissingError
    if a table lacks a row or a column that the page asks for.
    """

    def table(found: re.Match[str]) -> str:
        begin, name, title, choice, end = found.groups()
        part = _part(folder / f"{name}.json", title, _choices(choice), place)
        return f"{begin}\n{part}\n\n{end}"

    return _TABLE.sub(table, text)


def _choices(text: str) -> dict[str, list[str]]:
    """Parse `| rows: a; b | columns: c` into {"rows": ["a", "b"], "columns": ["c"]}."""
    parts = (part.partition(":") for part in text.split(" | ")[1:])
    return {word.strip(): [each.strip() for each in rest.split(";")] for word, _, rest in parts}


def _part(file: Path, title: str, choices: dict[str, list[str]], place: Path) -> str:
    """A caption with a link to the file, and the chosen part of the table without spreads."""
    recorded = tables_of([file])
    rows = recorded.rows(title)
    if not rows:
        return f"*Not measured yet: `python -m benchmarks {file.stem} --record`.*"
    first, *others = rows[0]
    columns = [first, *_chosen(others, choices.get("columns"), title)]
    if wanted := choices.get("rows"):
        by_name = {row[first]: row for row in rows}
        rows = [by_name[name] for name in _chosen(list(by_name), wanted, title)]
    cells = [[_SPREAD.sub("", row[column]) for column in columns] for row in rows]
    link = Path(os.path.relpath(file, place)).as_posix()
    return f"[{recorded.title(title)}]({link}):\n\n{Table('', columns, cells).body()}"


def _chosen(there: Sequence[str], asked: Sequence[str] | None, title: str) -> Sequence[str]:
    missing = [name for name in asked or () if name not in there]
    if missing:
        raise MissingError(f"the table {title!r} has no {missing}")
    return there if asked is None else asked
