"""Puts printed results into a page: between the markers of each section, and nowhere else."""

import os
from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.effort import MissingError
from benchmarks.harness.report import Section


def fill_each(
    pages: Sequence[Path], machine: dict[str, str], sections: Sequence[Section], plots: Path
) -> None:
    """`fill`, each section in the first of the pages that has its markers; MissingError if none."""
    texts = {page: page.read_text(encoding="utf-8") for page in pages}
    for section in sections:
        fitting = (page for page, text in texts.items() if f"<!-- {section.name} -->" in text)
        fill(next(fitting, pages[-1]), machine, [section], plots)


def fill(page: Path, machine: dict[str, str], sections: Sequence[Section], plots: Path) -> None:
    """Replace what stands between `<!-- NAME -->` and `<!-- /NAME -->` for each section's name.

    Each part begins with the machine it was measured on and ends with its plots, from the directory
    `plots`. Sections not run stay as they are; MissingError if a section has no markers.
    """
    folder = Path(os.path.relpath(plots, page.parent)).as_posix()
    for section in sections:
        shown = (_shown(folder, name) for name in section.plots)
        put(page, section.name, "\n\n".join([_part(machine, section), *shown]))


def put(page: Path, name: str, part: str) -> None:
    """Replace what stands between `<!-- NAME -->` and `<!-- /NAME -->`; MissingError without."""
    text = page.read_text(encoding="utf-8")
    page.write_text(_replaced(text, name, part), encoding="utf-8")


def _shown(folder: str, name: str) -> str:
    words = Path(name).stem.removeprefix("bench-").replace("-", " ")
    return f"![{words}]({folder}/{name})"


def _part(machine: dict[str, str], section: Section) -> str:
    about = ", ".join(f"{name} {value}" for name, value in machine.items())
    body = section.text().removeprefix(f"## {section.name}").strip()
    return f"Measured on: {about}.\n\n{body}"


def _replaced(text: str, name: str, part: str) -> str:
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    head, found, rest = text.partition(begin)
    _, closed, tail = rest.partition(end)
    if not (found and closed):
        raise MissingError(f"the page has no place for {name}: {begin} … {end}")
    return f"{head}{begin}\n\n{part}\n\n{end}{tail}"
