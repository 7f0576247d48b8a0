"""The list of benchmarks, and how one is run by name."""

import importlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section


class Benchmark(NamedTuple):
    """A module within `benchmarks`, and the question that it answers."""

    module: str
    question: str


GROUPS: Final[Mapping[str, Mapping[str, Benchmark]]] = MappingProxyType({
    "Is it right": {
        "accuracy": Benchmark(
            "accuracy.accuracy", "How far is each engine from the truth, at what speed?"
        ),
        "certified": Benchmark("accuracy.certified", "How many bins does rounding leave right?"),
        "literature": Benchmark("literature.literature", "Does it agree with published figures?"),
        "stability": Benchmark("stability.stability", "Does any scene break a solver?"),
    },
    "How fast is it": {
        "lanes": Benchmark("speed.lanes", "How many drops a second does each machine code give?"),
        "drop": Benchmark("speed.drop", "How long does one drop take, and a start?"),
        "growth": Benchmark("speed.growth", "What does an impact cost on larger boards?"),
        "features": Benchmark("speed.features", "What does a feature cost the scene that has it?"),
        "touching": Benchmark("speed.touching", "How fast and exact are balls that touch?"),
        "batches": Benchmark("speed.batches", "What does a cluster lose to one process?"),
    },
    "What does a server bear": {
        "replays": Benchmark("serving.replays", "How many requests a second does it answer?"),
        "pictures": Benchmark("serving.pictures", "How long do pictures and animations take?"),
        "stream": Benchmark("serving.stream", "What does it cost to show a room to many?"),
        "relays": Benchmark("serving.relays", "What does a spectator over a relay cost?"),
        "page": Benchmark("serving.page", "Does a browser show 200 balls smoothly?"),
        "stranger": Benchmark("serving.stranger", "How soon does a phone play that is new here?"),
        "scale": Benchmark("scale.units", "What do a room and a row of the ledger cost?"),
        "ledger": Benchmark("scale.ledger", "How large does the ledger grow?"),
        "silence": Benchmark("serving.silence", "How long are rooms silent on a busy machine?"),
        "attack": Benchmark("serving.attack.attack", "What do players notice of an attack?"),
    },
})  # fmt: skip
"""Every benchmark, in the order of the help and of `python -m benchmarks all`."""

BENCHMARKS: Final = {name: each for group in GROUPS.values() for name, each in group.items()}


def run(name: str, effort: Effort) -> Section:
    """Import and run the benchmark `name`."""
    module = importlib.import_module(f"benchmarks.{BENCHMARKS[name].module}")
    section: Section = module.run(effort)
    return section
