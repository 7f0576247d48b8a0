"""The time of one drop from Python, as JSON and as a process, and of a server's start."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from benchmarks.harness.clock import Job, Sample, in_turns, seconds_of, timed
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.serving.process import serving
from plinko.engine import Board, drop

BOARD: Final = "triangle-16"

COLD = ("exact", "and stepped", "and occupancy")
"""What COLD_PROGRAM has loaded each time that it prints the seconds."""

COLD_PROGRAM = """
import time
start = time.perf_counter()
from dataclasses import replace
from plinko.engine import Board, World, drop, drop_many, occupancy
board = Board.preset("triangle-16")
plain = replace(board, drag=0.0, ball=replace(board.ball, friction=0.0))
drop(board, 1).certain
drop_many(plain, range(2))
for solver in ("exact", "stepped"):
    drop(board, 1, solver=solver).states([0.5])
    drop_many(board, range(2), solver=solver)
    world = World(board, solver=solver)
    world.add(1)
    world.step()
    print(time.perf_counter() - start)
occupancy(board, range(2), left=-1.0, top=0.0, cells_per_metre=8.0, shape=(16, 16))
print(time.perf_counter() - start)
"""


def run(effort: Effort) -> Section:
    section = Section("drop")
    _calls(section, effort)
    _starts(section, effort)
    return section


def _calls(section: Section, effort: Effort) -> None:
    drops = effort.size(2000, 20)
    board = Board.preset(BOARD)
    ways: dict[str, Callable[[int], object]] = {
        "`drop(board, seed)`": lambda seed: drop(board, seed),
        "and its impacts": lambda seed: drop(board, seed).impacts,
        "and its record as JSON": lambda seed: drop(board, seed).to_json(),
    }
    times = in_turns(
        {name: _each(way, drops) for name, way in ways.items()},
        effort.rounds,
        lambda: effort.step("calls"),
    )
    section.data["calls"] = {name: sample.to_dict() for name, sample in times.items()}
    section.tables.append(
        Table(
            "A drop called from Python",
            ["what", "µs"],
            [[name, spread(sample, "{:.0f}")] for name, sample in times.items()],
            [
                f"{BOARD}, processor time of one thread, the mean of {drops:,} seeds one after the "
                "other; of the rounds the median (smallest to largest)."
            ],
        )
    )


def _each(way: Callable[[int], object], drops: int) -> Job:
    """A job that returns the mean microseconds of a drop."""

    def work() -> None:
        for seed in range(drops):
            way(seed)

    return lambda: seconds_of(work, time.thread_time) * 1e6 / drops


def _starts(section: Section, effort: Effort) -> None:
    """Measure the loading of each solver, and whole processes."""
    runs = effort.size(5, 1)
    cold = [Sample(tuple(s)) for s in zip(*_cold_starts(effort.size(3, 1)), strict=True)]
    effort.step("cold start")
    command = [sys.executable, "-m", "plinko", "drop", "triangle-16", "--seed", "42", "--json"]
    warm = in_turns(
        {
            "plinko drop": timed(lambda: _run(command)),
            "python": timed(lambda: _run([sys.executable, "-c", "pass"])),
        },
        runs,
        lambda: effort.step("warm start"),
    )
    servers = [_server_start() for _ in range(effort.size(3, 1))]
    effort.step("server")
    ready, megabytes = (Sample(tuple(each)) for each in zip(*servers, strict=True))
    section.tables.append(
        Table(
            "Start-up, seconds",
            ["what", "s"],
            [
                ["import and load the exact solver", spread(cold[0])],
                ["the stepped solver too", spread(cold[1])],
                ["occupancy too", spread(cold[2])],
                ["`plinko drop triangle-16 --seed 42 --json`", spread(warm["plinko drop"])],
                ["an empty Python program", spread(warm["python"])],
                ["`plinko serve` with no ledger yet, until it takes drops", spread(ready)],
                ["its memory then, MB", spread(megabytes)],
            ],
            [
                "Whole processes, from start to exit, but for the first three rows: from the first "
                "import. The exact solver: single drops, where they are in between and how sure "
                "they are, batches with and without drag and friction, live worlds. The stepped "
                "one: single drops, where they are in between, batches, live worlds. Balls that "
                "touch are not in it."
            ],
        )
    )
    section.data["starts"] = {
        **{name: sample.to_dict() for name, sample in zip(COLD, cold, strict=True)},
        **{name: sample.to_dict() for name, sample in warm.items()},
        "plinko serve": ready.to_dict(),
        "plinko serve, MB": megabytes.to_dict(),
    }


def _server_start() -> tuple[float, float]:
    """Seconds until a server with a new ledger takes drops, and its memory then, MB."""
    began = time.perf_counter()
    with serving() as served:
        return time.perf_counter() - began, served.resident / 1e6


def _cold_starts(count: int) -> list[list[float]]:
    """Seconds from the first import to each of COLD, for `count` runs."""
    told = [_run([sys.executable, "-c", COLD_PROGRAM]).split() for _ in range(count)]
    return [[float(seconds) for seconds in each] for each in told]


def _run(command: list[str]) -> str:
    """Run a command and return its output.

    Python may write bytecode even if this process may not, as for an installed program.
    """
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
        env=kept,
    ).stdout
