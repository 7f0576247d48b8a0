"""Shows recorded tables in pages, at a comment that names the file and the table in it:

    <!-- table accuracy: Error against the oracle | rows: plinko exact; Chipmunk 1/240 -->

A table is named by its title or the beginning of it. A page that does not show the whole table
lists rows, by their first cells, and columns other than the first. The site draws the tables of
docs; the README has a copy of its table, before a comment `<!-- /table -->`.
"""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from benchmarks.harness.effort import MissingError
from benchmarks.harness.recorded import DOCS, FOLDER, tables_of
from benchmarks.harness.report import Table

README: Final = DOCS.parent / "README.md"

_MARK = re.compile(r"<!-- table ([\w-]+): ([^|]*?)((?: \| .*?)?) -->")
_COPY = re.compile(rf"({_MARK.pattern}\n).*?(<!-- /table -->)", re.DOTALL)
_SPREAD = re.compile(r" \([^()]* to [^()]*\)$")
"""The spread in a cell, which a file shows after the median and a page does not."""


def drawn(text: str, place: Path, folder: Path = FOLDER) -> str:
    """Put each table of a page in the folder `place` where its comment is.

    A table that is not recorded yet is replaced by the command that records it. Raises MissingError
    if a table lacks a row or a column that the page asks for.
    """
    return _MARK.sub(lambda found: _part(folder, place, *found.groups()), text)


def filled(text: str, place: Path, folder: Path = FOLDER) -> str:
    """Renew the copy of each table; raises as `drawn` does."""

    def copy(found: re.Match[str]) -> str:
        begin, *table, end = found.groups()
        return f"{begin}\n{_part(folder, place, *table)}\n\n{end}"

    return _COPY.sub(copy, text)


def _part(folder: Path, place: Path, name: str, title: str, choice: str) -> str:
    """A caption with a link to the file, and the chosen part of the table without spreads."""
    file = folder / f"{name}.json"
    recorded, choices = tables_of([file]), _choices(choice)
    rows = recorded.rows(title)
    if not rows:
        return f"*Not measured yet: `python -m benchmarks {name} --record`.*"
    first, *others = rows[0]
    columns = [first, *_chosen(others, choices.get("columns"), title)]
    if wanted := choices.get("rows"):
        by_name = {row[first]: row for row in rows}
        rows = [by_name[each] for each in _chosen(list(by_name), wanted, title)]
    cells = [[_SPREAD.sub("", row[column]) for column in columns] for row in rows]
    link = Path(os.path.relpath(file, place)).as_posix()
    return f"[{recorded.title(title)}]({link}):\n\n{Table('', columns, cells).body()}"


def _choices(text: str) -> dict[str, list[str]]:
    """Parse `| rows: a; b | columns: c` into {"rows": ["a", "b"], "columns": ["c"]}."""
    parts = (part.partition(":") for part in text.split(" | ")[1:])
    return {word.strip(): [each.strip() for each in rest.split(";")] for word, _, rest in parts}


def _chosen(there: Sequence[str], asked: Sequence[str] | None, title: str) -> Sequence[str]:
    missing = [name for name in asked or () if name not in there]
    if missing:
        raise MissingError(f"the table {title!r} has no {missing}")
    return there if asked is None else asked
