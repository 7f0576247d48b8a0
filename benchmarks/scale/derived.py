"""The derived part of docs/scale.md, from what that page and docs/benchmarks.md record."""

from pathlib import Path
from typing import Final

from benchmarks.scale.estimates import tables, units_of
from benchmarks.scale.recorded import Recorded

DOCS: Final = Path(__file__).parents[2] / "docs"
PAGE: Final = DOCS / "scale.md"
NAME: Final = "derived"


def derived() -> str:
    """Its tables in Markdown; MissingError where a page does not record what they follow from."""
    pages = (DOCS / "benchmarks.md", PAGE)
    recorded = Recorded("\n".join(page.read_text(encoding="utf-8") for page in pages))
    return "\n\n".join(table.text() for table in tables(units_of(recorded)))
