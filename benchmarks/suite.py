"""The benchmarks by name."""

import importlib
from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section

MODULES = {
    "accuracy": "accuracy.accuracy",
    "certified": "accuracy.certified",
    "throughput": "speed.throughput",
    "lanes": "speed.lanes",
    "stability": "stability.stability",
    "batches": "speed.batches",
    "features": "speed.features",
    "stream": "serving.stream",
    "page": "serving.page",
    "stranger": "serving.stranger",
    "render": "serving.render",
    "stepped": "speed.stepped",
    "relays": "serving.relays",
    "literature": "literature.literature",
    "scale": "scale.units",
    "attack": "serving.attack.attack",
    "silence": "serving.silence",
}
"""Where in this package each benchmark is, in the order in which all of them run."""

NAMES = tuple(MODULES)


def run(name: str, effort: Effort) -> Section:
    """Run the benchmark `name`; each is imported when it is asked for."""
    section: Section = importlib.import_module(f"benchmarks.{MODULES[name]}").run(effort)
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
