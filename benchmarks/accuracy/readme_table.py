"""The README's short table and plot: taken from the run that the benchmarks' page records."""

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.accuracy import accuracy
from benchmarks.harness.markers import put

NAME = "benchmarks"
BOARD = "trial-16"
TITLE = accuracy.HEADING + accuracy.BOARDS[BOARD][0]
PLOT = accuracy.plot_of(BOARD)
COLUMNS = ("after impact 2", "after impact 8", "same bin, decidable", "drops/s")
RATE = 240
"""Steps a second at which contestants are shown that have steps; others are always shown."""

Row = Sequence[str]


def renew(readme: Path, page: Path) -> None:
    """Put the table of `page`, and a link to its plot, between the README's markers.

    MissingError if the README has no place for it. A page without a recorded run leaves the README
    saying so.
    """
    put(readme, NAME, summary(page.read_text(encoding="utf-8"), _link(readme, page)))


def _link(readme: Path, page: Path) -> str:
    """The page as seen from the README."""
    return Path(os.path.relpath(page, readme.parent)).as_posix()


def summary(text: str, link: str) -> str:
    """The README's block, from the text of the page at `link`."""
    table = _table(text)
    if not table:
        return f"No run is recorded yet: `make bench` fills [the page of benchmarks]({link})."
    names, *rows = table
    chosen = [0, *(names.index(name) for name in COLUMNS)]
    lines = [names, *(row for row in rows if _is_shown(row[0]))]
    cells = [[row[i] for i in chosen] for row in lines]
    rule = ["---", *("---:" for _ in COLUMNS)]
    body = "\n".join(f"| {' | '.join(row)} |" for row in [cells[0], rule, *cells[1:]])
    plot = f"{Path(link).parent.as_posix()}/images/{PLOT}"
    return (
        f"{body}\n\n"
        "Median error of the position after so many impacts, against an oracle of thirty digits; "
        "how many of the drops whose bin double precision can decide end in that bin; and drops a "
        f"second on one core. Sixteen rows, drag, friction and spin. [Benchmarks]({link}) says "
        "how, on which machine, and all the rest.\n\n"
        f"![Error of the position against drops a second, for this engine and others]({plot})"
    )


def _is_shown(name: str) -> bool:
    rate = re.search(r" 1/(\d+)$", name)
    return rate is None or int(rate[1]) == RATE


def _table(text: str) -> list[Row]:
    """The cells of the table under TITLE, its head first; none if it is not there."""
    _, found, rest = text.partition(f"### {TITLE}\n")
    return list(_rows(rest.lstrip("\n"))) if found else []


def _rows(text: str) -> Iterator[Row]:
    for line in text.splitlines():
        if not line.startswith("|"):
            return
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not set(cells[0]) <= {"-"}:
            yield cells
