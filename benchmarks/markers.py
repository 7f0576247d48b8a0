"""Puts printed results into a page: between the markers of each section, and nowhere else."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.report import Section
from benchmarks.settings import MissingError


def fill(page: Path, machine: dict[str, str], sections: Sequence[Section]) -> None:
    """Replace what stands between `<!-- NAME -->` and `<!-- /NAME -->` for each section's name.

    Each part begins with the machine it was measured on. Sections not run stay as they are;
    MissingError if a section has no markers.
    """
    text = page.read_text(encoding="utf-8")
    for section in sections:
        text = _replaced(text, section.name, _part(machine, section))
    page.write_text(text, encoding="utf-8")


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
