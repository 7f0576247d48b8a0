"""The results of a benchmark: tables in Markdown for people, numbers in JSON for programs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from benchmarks.harness.clock import Sample


@dataclass(frozen=True)
class Table:
    """A table with a title above it and remarks below it."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = ()

    def text(self) -> str:
        return "\n\n".join([f"## {self.title}", self.body(), *self.notes])

    def body(self) -> str:
        """Only the table. Cells are padded, so that it is readable in a terminal."""
        cells = [list(self.columns), *([str(cell) for cell in row] for row in self.rows)]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.columns))]
        lines = []
        for number, row in enumerate(cells):
            lines.append(_line(row, widths))
            if number == 0:
                rules = ["-" * widths[0]] + ["-" * (width - 1) + ":" for width in widths[1:]]
                lines.append("| " + " | ".join(rules) + " |")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        return {
            "title": self.title,
            "columns": list(self.columns),
            "rows": [list(row) for row in self.rows],
            "notes": list(self.notes),
        }


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    first = row[0].ljust(widths[0])
    rest = (cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))
    return "| " + " | ".join([first, *rest]) + " |"


@dataclass
class Section:
    """The results of one benchmark: tables, the numbers behind them, and absent contestants."""

    name: str
    tables: list[Table] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)
    absent: list[str] = field(default_factory=list)
    plots: dict[str, Callable[[str], None]] = field(default_factory=dict)
    """By each plot's file name, the function that draws the plot into a path."""

    def text(self) -> str:
        parts = [table.text() for table in self.tables]
        if self.absent:
            parts.append("Not taking part:\n\n" + "\n".join(f"- {line}" for line in self.absent))
        return "\n\n".join(parts)

    def to_dict(self) -> dict[str, Any]:
        return {
            "tables": [table.to_dict() for table in self.tables],
            "data": self.data,
            "absent": self.absent,
        }


def spread(sample: Sample, form: str = "{:.3g}") -> str:
    """`median (low to high)`, or the value itself if the sample has only one."""
    if len(sample.values) == 1:
        return form.format(sample.median)
    return f"{form.format(sample.median)} ({form.format(sample.low)} to {form.format(sample.high)})"


def length(metres: float) -> str:
    """A length with two digits and a unit that suits its size."""
    if metres == 0.0:
        return "0"
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9), ("pm", 1e-12)):
        if abs(metres) >= size:
            number = metres / size
            return f"{number:.2g} {unit}" if number < 99.5 else f"{number:.0f} {unit}"
    return f"{metres:.1e} m"
