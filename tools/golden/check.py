"""Compares the golden digests of drops with those that this machine computes.

    python -m tools.golden.check [--quick]

prints each digest that differs and exits with 1 if any does. It needs only the engine, so that it
also runs on emulated processors and without the JIT. `--quick` is for these: it plays one drop per
solver on each board, of those that differ only in payouts on one.
"""

import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.engine import PHYSICS_VERSION, Board, drop, drop_many
from plinko.engine.parameters import SolverName
from tests.kit.presets import SAMPLE

FILE = Path(__file__).parents[2] / "tests" / "golden" / "digests.json"

SOLVERS: tuple[SolverName, ...] = ("exact", "stepped")
SEEDS = (42, 0, 1, 4_294_967_296, 18_446_744_073_709_551_615)
BATCH: dict[SolverName, int] = {"exact": 1000, "stepped": 100}
"""By solver, the number of drops (seeds 0, 1, …) in each batch digest."""

Entry = dict[str, Any]


def board_of(name: str) -> Board:
    """The board of a golden entry: a preset, or the board of `scene:NAME`."""
    kind, _, rest = name.rpartition(":")
    return scene(rest).board if kind == "scene" else Board.preset(name)


def names() -> tuple[str, ...]:
    """All golden entries: the house table's presets, one of each world, and every scene."""
    return (*SAMPLE, *(f"scene:{name}" for name in scene_names()))


def entry(name: str, count: int = len(SEEDS)) -> Entry:
    """Digests of the first `count` golden seeds on a board, by both solvers."""
    board = board_of(name)
    found: Entry = {"board_digest": board.digest}
    for solver in SOLVERS:
        found[solver] = [drop(board, seed, solver=solver).digest for seed in SEEDS[:count]]
    return found


def batch_entry(name: str) -> Entry:
    """Digests of the outcomes of many drops, by both solvers."""
    board = board_of(name)
    return {
        solver: drop_many(board, range(count), solver=solver, threads=1).digest
        for solver, count in BATCH.items()
    }


def batch_names() -> tuple[str, ...]:
    """Entries with a batch, and of `--quick`: balls fall in the same way on payout variants."""
    return tuple(name for name in names() if not name.endswith(("-low", "-high")))


def current() -> dict[str, Any]:
    """All golden digests as this machine computes them."""
    return {
        "physics_version": PHYSICS_VERSION,
        "seeds": [str(seed) for seed in SEEDS],
        "drops": {name: entry(name) for name in names()},
        "batches": {name: batch_entry(name) for name in batch_names()},
    }


def golden() -> dict[str, Any]:
    """The committed digests."""
    content: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return content


def differences(expected: Entry, actual: Entry, name: str) -> list[str]:
    """One line for each difference between two entries; lists are compared up to `actual`'s end."""
    lines = []
    for key, value in actual.items():
        wanted = expected.get(key)
        if isinstance(value, list) and isinstance(wanted, list):
            pairs = zip(SEEDS, wanted, value, strict=False)
            lines += [f"{name} {key} seed {s}: {b} not {a}" for s, a, b in pairs if a != b]
        elif value != wanted:
            lines.append(f"{name} {key}: {value} not {wanted}")
    return lines


def main(arguments: list[str]) -> int:
    """Compare everything, or with --quick one drop by each solver."""
    quick = "--quick" in arguments
    expected = golden()
    lines = []
    boards, count = (batch_names(), 1) if quick else (names(), len(SEEDS))
    for name in boards:
        lines += differences(expected["drops"][name], entry(name, count), name)
    for name in () if quick else batch_names():
        lines += differences(expected["batches"][name], batch_entry(name), f"batch {name}")
    compared = len(boards) * len(SOLVERS) * count
    report = "\n".join(lines) or f"{compared} drops have the golden digests"
    print(report)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
