"""The artifacts beside numba's code of the same kernels: python -m benchmarks.speed.artifact

Not among the benchmarks of `plinko bench`: numba compiles for a minute, and the table is only asked
for when it is to be decided again what runs. `--page docs/benchmarks.md` puts it into the page.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from benchmarks.harness.clock import in_turns, seconds_of
from benchmarks.harness.machine import describe
from benchmarks.harness.markers import fill
from benchmarks.harness.report import Section, Table, spread
from engine import Board, drop, drop_many, occupancy
from engine.exact.lanes.trace import trace_lanes, trace_plain_lanes
from engine.exact.occupancy import occupy
from engine.exact.trace import trace_many
from engine.jit import kernel_compiler, machine_code
from engine.jit.decorator import EntryKernel
from engine.multibody.scenes import sandbox
from engine.multibody.solver.neighbour_list import rebuild
from engine.multibody.solver.step import step_balls
from engine.stepped.step import step_many

ROUNDS = 7

BOARD = Board.preset("triangle-16")
SMOOTH = replace(BOARD, drag=0.0, ball=replace(BOARD.ball, friction=0.0))


def heap(balls: int, steps: int) -> str:
    """Digest of balls that fall into a box."""
    arena = sandbox(balls, seed=3, width=0.8 * balls**0.5, height=0.6 * balls**0.5)
    for _ in range(steps):
        arena.step()
    return arena.digest()


def density(drops: int) -> str:
    """Where balls are, as text."""
    grid: dict[str, Any] = {"left": -4.0, "top": 0.0, "cells_per_metre": 20.0, "shape": (120, 160)}
    return occupancy(BOARD, range(drops), threads=1, **grid).counts.tobytes().hex()


WORK: dict[str, tuple[tuple[Any, ...], Callable[[], str]]] = {
    "4,000 drops": (
        (trace_lanes,),
        lambda: drop_many(BOARD, range(4000), threads=1).digest,
    ),
    "`drop` called 2,000 times": (
        (trace_many,),
        lambda: "".join(drop(BOARD, seed).digest for seed in range(2000)),
    ),
    "9,000 drops without drag and friction": (
        (trace_plain_lanes,),
        lambda: drop_many(SMOOTH, range(9000), threads=1).digest,
    ),
    "where 1,500 drops are": ((trace_many, occupy), lambda: density(1500)),
    "200 drops of the stepped solver": (
        (step_many,),
        lambda: drop_many(BOARD, range(200), solver="stepped", threads=1).digest,
    ),
    "60 balls that touch, 120 steps": ((step_balls, rebuild), lambda: heap(60, 120)),
    "600 balls that touch, 30 steps": ((step_balls, rebuild), lambda: heap(600, 30)),
}
"""What is timed: the kernels that Python calls in it, and work that ends in a digest."""


def row(what: str, rounds: int) -> list[str]:
    """Processor times of both, and how fast the artifact is; ValueError if their bits differ."""
    kernels, work = WORK[what]
    codes: dict[str, Callable[[EntryKernel[Any, Any]], Any]]
    codes = {"artifact": machine_code.entry, "numba": kernel_compiler.compiled}
    digests = set()

    def job(find: Callable[[EntryKernel[Any, Any]], Any]) -> Callable[[], float]:
        def run() -> float:
            for kernel in kernels:
                kernel.machine_code = find(kernel)
            return seconds_of(lambda: digests.add(work()), time.process_time)

        return run

    times = in_turns({name: job(find) for name, find in codes.items()}, rounds)
    if len(digests) != 1:
        raise ValueError(f"{what}: the digests differ")
    ratio = spread(times["numba"].over(times["artifact"]))
    return [what, spread(times["artifact"]), spread(times["numba"]), ratio]


@click.command()
@click.option("--page", type=Path, help="Put the table into this page, between its markers, too.")
@click.option("--quick", is_flag=True, help="One round, to see that it works.")
def main(page: Path | None, quick: bool) -> None:
    """Print the table."""
    columns = ["what", "artifact, s", "numba, s", "speed of the artifact"]
    rounds = 1 if quick else ROUNDS
    notes = [
        f"Processor seconds of one thread, {rounds} round(s) in turns. The digests are the same."
    ]
    rows = [row(what, rounds) for what in WORK]
    section = Section("machine-code", [Table("By wasmtime and by numba", columns, rows, notes)])
    print(section.text())
    if page is not None:
        fill(page, describe(), [section], page.parent)


if __name__ == "__main__":
    main()
