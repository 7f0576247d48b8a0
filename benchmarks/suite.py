"""The benchmarks by name."""

import importlib
from collections.abc import Sequence
from pathlib import Path

from benchmarks.report import Section
from benchmarks.settings import Settings

NAMES = ("accuracy", "throughput", "stability", "features", "stream", "page", "render", "stepped")


def run(name: str, settings: Settings) -> Section:
    """Run the benchmark `name`; each is imported when it is asked for."""
    section: Section = importlib.import_module(f"benchmarks.{name}").run(settings)
    return section


def draw(sections: Sequence[Section], directory: Path) -> list[Path]:
    """Draw all figures of `sections` into a directory, made if need be; returns their paths."""
    directory.mkdir(parents=True, exist_ok=True)
    paths = []
    for section in sections:
        for name, plot in section.plots.items():
            path = directory / name
            plot(str(path))
            paths.append(path)
    return paths
