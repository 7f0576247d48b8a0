"""Figures that a page records: its tables by their titles, and the number in a cell."""

import re
from dataclasses import dataclass

from benchmarks.harness.effort import MissingError

_NUMBER = re.compile(r"[+-]?[\d,]+(\.\d+)?(e[+-]?\d+)?")


@dataclass(frozen=True)
class Recorded:
    """The tables of some pages, each under a title of its own."""

    text: str

    def number(self, title: str, row: str, column: str) -> float:
        """The number at the beginning of a cell; MissingError where there is none."""
        for cells in self.rows(title):
            if next(iter(cells.values())) != row:
                continue
            cell = cells.get(column, "")
            found = _NUMBER.match(cell)
            if found:
                return float(found[0].replace(",", "")) * (0.01 if cell.endswith("%") else 1.0)
        raise MissingError(f"no page records {column!r} of {row!r} under {title!r}")

    def has(self, title: str) -> bool:
        """Whether there is a table of this title."""
        return bool(self._lines(title))

    def rows(self, title: str) -> list[dict[str, str]]:
        """The rows of a table, each cell under its column's name; none without a table."""
        header, _, *body = map(_cells, self._lines(title) or ["", ""])
        return [dict(zip(header, cells, strict=True)) for cells in body]

    def _lines(self, title: str) -> list[str]:
        """The lines of the table that follows this heading; none where there is no such heading."""
        _, found, rest = self.text.partition(f"\n### {title}\n")
        lines: list[str] = []
        for line in rest.splitlines() if found else ():
            if line.startswith("|"):
                lines.append(line)
            elif lines or line.startswith("#"):
                break
        return lines


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]
