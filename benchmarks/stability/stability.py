"""Counts faults in scenes made to break a solver, and on random boards."""

import json
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from benchmarks.harness import machine
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.scenes import random_boards
from benchmarks.stability import torture, touching_torture
from benchmarks.stability.invariants import FAULTS, Findings, examine
from plinko.engine import Board, World
from plinko.engine.batches.workers import workers_at
from plinko.engine.parameters import SolverName

STARTS = 100
"""Starts on each random board."""

SOLVERS: dict[SolverName, dict[str, Any]] = {
    "exact": {"solver": "exact"},
    "stepped": {"solver": "stepped"},
}

Totals = defaultdict[tuple[str, SolverName], Findings]
"""Findings by part of the benchmark and solver."""

TORTURE, RANDOM = "torture catalogue", "random boards"


def run(effort: Effort) -> Section:
    section = Section("stability")
    totals: Totals = defaultdict(Findings)
    tables = [
        _catalogue(totals, effort),
        _crowds(effort),
        _touching(section, effort),
        _random(totals, effort),
    ]
    section.tables += [_together(totals, section.data["touching"]), *tables]
    kept = [item for found in totals.values() for item in found.kept]
    section.data["findings"] = kept
    for (part, solver), found in totals.items():
        section.data[f"{part}, {solver}"] = {
            "drops": found.drops,
            "faults": {what: found.faults[what] for what in FAULTS},
            "unsettled": dict(found.unsettled),
        }
    if effort.findings and kept:
        _save(kept, effort.findings)
    return section


def _save(kept: list[dict[str, Any]], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, item in enumerate(kept):
        name = f"{item['fault'].replace(' ', '-')}-{item['solver']['solver']}-{number:02}.json"
        (folder / name).write_text(json.dumps(item, indent=1))


COLUMNS = ["scene", "solver", "drops", *FAULTS, "unsettled"]


def _row(name: str, solver: SolverName, found: Findings) -> list[str]:
    reasons = ", ".join(f"{count:,} {why}" for why, count in sorted(found.unsettled.items()))
    counts = [f"{found.faults[what]:,}" for what in FAULTS]
    return [name, solver, f"{found.drops:,}", *counts, reasons or "0"]


def _together(totals: Totals, touching: list[dict[str, Any]]) -> Table:
    """The sums of the other tables."""
    rows = [_row(part, solver, found) for (part, solver), found in totals.items()]
    frames = sum(each["frames"] for each in touching)
    counts = [f"{sum(each['faults'][what] for each in touching):,}" for what in FAULTS]
    rows.append(["balls that touch", "touching", f"{frames:,} frames", *counts, ""])
    return Table("All scenes together", COLUMNS, rows)


def _catalogue(totals: Totals, effort: Effort) -> Table:
    rows = []
    for scene in torture.catalogue(effort.size(200, 3)):
        for name, solver in SOLVERS.items():
            if name == "exact" and scene.stepped:
                continue
            xs = scene.xs[:5] if effort.quick else scene.xs
            found = examine(scene.board, xs, solver | scene.stepped)
            totals[TORTURE, name].add(found)
            rows.append(_row(scene.name, name, found))
            effort.step("torture")
    return Table(
        "Torture catalogue",
        COLUMNS,
        rows,
        [
            "Every path is looked at at its events and twelve instants between each two, against "
            "the board as given. Tunnelling: an overlap with a peg or a wall above 1e-9 of the "
            "sizes involved (for the stepped solver 1e-4 of the ball's radius, since a notch "
            "presses it from one surface into the other), or a passage through a wall. Energy "
            "growth: with the exact solver any above rounding, with the stepped one more than its "
            "order allows (g dt |v| an impact). Traps are there to trap: a ball in a notch has to "
            "end as unsettled."
        ],
    )


def _crowds(effort: Effort) -> Table:
    """Balls that start in the same place in a live world: none may change another's path."""
    board = Board.preset("triangle-8")
    balls = effort.size(500, 20)
    rows = []
    for name in SOLVERS:
        world = World(board, solver=name)
        for _ in range(balls):
            world.add(x=0.01)
        ends = set()
        ticks = 0
        while world.awake and ticks < 100_000:
            world.step()
            ticks += 1
            ends |= {event.digest for event in world.take_events() if hasattr(event, "digest")}
        rows.append([name, str(balls), str(len(ends)), "0" if not world.awake else "1"])
        effort.step("crowds")
    return Table(
        "Balls that start in the same place",
        ["solver", "balls", "different paths", "hangs"],
        rows,
        ["One path means that no ball changed another's."],
    )


def _touching(section: Section, effort: Effort) -> Table:
    """Balls that touch each other: the number of frames with a fault."""
    rows = []
    section.data["touching"] = []
    for scene in touching_torture.catalogue(effort.quick):
        seen = touching_torture.watch(scene)
        counts = [f"{seen.faults[what]:,}" for what in FAULTS]
        rows.append(
            [
                scene.name,
                str(scene.arena.count),
                f"{seen.frames:,}",
                *counts,
                f"{100.0 * seen.deepest:.2f} %",
            ]
        )
        section.data["touching"].append(touching_torture.to_dict(scene, seen))
        effort.step("balls that touch")
    return Table(
        "Balls that touch each other",
        ["scene", "balls", "frames", *FAULTS, "deepest overlap, of the radius"],
        rows,
        [
            "Every frame is looked at; counted are frames. Tunnelling: an overlap of more than "
            "half the smaller radius; escape: a ball outside of the walls, or gone; hang: a frame "
            "of 20 s; energy growth: by more than 0.5 % of all there is and what the lag of "
            "velocities by half a substep shows. Of balls put in one place overlap and energy "
            "count in the last quarter, when they had time to part."
        ],
    )


def _random(totals: Totals, effort: Effort) -> Table:
    drops = effort.size(100_000, 200) if not effort.long else 10_000_000
    boards = max(1, drops // STARTS)
    rows = []
    for name, solver in SOLVERS.items():
        found = Findings()
        share = boards if name == "exact" else max(1, boards // 4)  # a stepped drop costs more
        count = min(STARTS, drops)
        jobs = [(seed, count, solver) for seed in range(share)]
        if effort.quick or effort.cluster:
            with workers_at(effort.cluster, 1 if effort.cluster is None else None) as workers:
                for _, part in workers.compute(_one_board, jobs):
                    found.add(part)
                    effort.step(f"random boards, {name}")
        else:
            with ProcessPoolExecutor(machine.cores(), mp_context=get_context("spawn")) as pool:
                for part in pool.map(partial(_one_board, threads=1), jobs, chunksize=4):
                    found.add(part)
                    effort.step(f"random boards, {name}")
        totals[RANDOM, name].add(found)
        rows.append(_row(f"{share:,} boards", name, found))
    return Table(
        "Random boards and starts that the validator allows",
        COLUMNS,
        rows,
        [
            "Restitution 0 to 1, friction 0 to 10, gravity and drag over decades, scale from 1 cm "
            "to 100 m, bars in a third of them; half of the starts anywhere, half within four "
            "units in the last place of a peg's middle or rim."
        ],
    )


def _one_board(job: tuple[int, int, dict[str, Any]], threads: int) -> Findings:
    seed, count, solver = job
    board = random_boards.random_board(seed)
    return examine(board, random_boards.starts(board, count, seed), solver)
