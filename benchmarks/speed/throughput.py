"""Drops per second, nanoseconds per impact beside what arithmetic allows, and start-up times."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.harness import machine
from benchmarks.harness.clock import Job, Sample, in_turns, timed
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards as scenes
from benchmarks.serving.process import serving
from benchmarks.speed import arithmetic, operations, page_drops
from engine import Board, drop_many

THIN = scenes.PLAIN._replace(restitution=0.5)
"""On the lattice: bounces so low that most balls hit one peg in each row."""

DROPS = 262_144
"""Drops in a round: nearly a second's work or more, or the start of threads would show in it."""

COLD = ("exact", "and stepped", "and occupancy")
"""What has been loaded each time that COLD_PROGRAM tells the seconds."""

COLD_PROGRAM = """
import time
start = time.perf_counter()
from dataclasses import replace
from engine import Board, World, drop, drop_many, occupancy
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
    """All of the speed benchmark."""
    section = Section("throughput")
    _boards(section, effort)
    page_drops.compare(section, effort)
    _sizes(section, effort)
    _starts(section, effort)
    return section


def _many(board: Board, drops: int, threads: int, **solver: Any) -> Callable[[], object]:
    return lambda: drop_many(board, range(drops), threads=threads, **solver)


def _impacts(board: Board, drops: int, **solver: Any) -> float:
    """Mean impacts of a drop; the first call also compiles and lays the board out."""
    return float(drop_many(board, range(drops), **solver).impact_count.mean())


def _boards(section: Section, effort: Effort) -> None:
    """Drops per second on one core and on all, and the limit set by arithmetic."""
    boards = {
        "12 rows, no friction, no drag": scenes.triangle(12, scenes.PLAIN),
        "12 rows of thin pegs, the same": scenes.lattice(12, 24, THIN),
        "triangle-16, everything": Board.preset("triangle-16"),
    }
    drops = effort.size(DROPS, 512)
    cores = machine.cores()
    jobs: dict[str, Job] = dict(arithmetic.jobs(effort.size(arithmetic.SWEEPS, 500)))
    impacts = {}
    for name, board in boards.items():
        impacts[name] = _impacts(board, drops)
        jobs[f"{name}/one"] = timed(_many(board, drops, 1))
        jobs[f"{name}/all"] = timed(_many(board, drops, cores))
        jobs[f"{name}/stepped"] = timed(_many(board, drops // 8, 1, solver="stepped"))
        _impacts(board, 1, solver="stepped")
    times = in_turns(jobs, effort.rounds, lambda: effort.step("boards"))
    section.tables.append(_speed_table(boards, times, impacts, drops, cores, effort.rounds))
    counts = {
        name: operations.count_apart(board.to_json(), effort.size(100, 2))
        for name, board in boards.items()
    }
    effort.step("operations")
    section.tables.append(_arithmetic_table(times))
    section.tables.append(_limit_table(times, impacts, counts, drops))
    section.data["boards"] = {
        "drops": drops,
        "impacts_per_drop": impacts,
        "operations_per_impact": counts,
        "seconds": {name: sample.to_dict() for name, sample in times.items()},
    }


def _speed_table(
    boards: dict[str, Board],
    times: dict[str, Sample],
    impacts: dict[str, float],
    drops: int,
    cores: int,
    rounds: int,
) -> Table:
    rows = []
    for name in boards:
        one = times[f"{name}/one"].map(lambda s: drops / s)
        every = times[f"{name}/all"].map(lambda s: drops / s)
        stepped = times[f"{name}/stepped"].map(lambda s: drops // 8 / s)
        rows.append(
            [
                name,
                f"{impacts[name]:.1f}",
                spread(one, "{:,.0f}"),
                spread(every, "{:,.0f}"),
                f"{every.over(one).median:.2f}",
                spread(stepped, "{:,.0f}"),
            ]
        )
    return Table(
        "Drops per second",
        ["board", "impacts a drop", "exact, one core", f"exact, {cores} cores", "ratio", "stepped"],
        rows,
        [
            f"Median (smallest to largest) of {rounds} round(s) of {drops:,} drops, contestants in "
            "turns; the ratio is the median of the rounds' ratios. Thin pegs, restitution 0.5: "
            "about one impact a row, and longer flights. Stepped: dt = 1/60 s, 4 substeps, one "
            "core."
        ],
    )


def _arithmetic_table(times: dict[str, Sample]) -> Table:
    return Table(
        "Arithmetic of this machine, one core",
        ["operation on float64", "ns each"],
        [[meaning, spread(times[name], "{:.3f}")] for name, meaning in arithmetic.MEANING.items()],
        [
            "Measured in the same rounds. The engine may not fuse, since processors that cannot "
            "would give other bits; independent operations fill all vector lanes."
        ],
    )


def _limit_table(
    times: dict[str, Sample],
    impacts: dict[str, float],
    counts: dict[str, dict[str, float]],
    drops: int,
) -> Table:
    rows = []
    for name, count in counts.items():
        measured = _per_impact(times[f"{name}/one"], drops, impacts[name])
        limit = least_time(count, times)
        rows.append(
            [
                name,
                *(f"{count[kind]:.1f}" for kind in operations.KINDS),
                spread(measured, "{:,.0f}"),
                f"{limit:.0f}",
                f"{measured.median / limit:.1f}",
            ]
        )
    return Table(
        "Nanoseconds per impact, exact solver, one core",
        ["board", *operations.LABELS, "ns", "limit", "times the limit"],
        rows,
        [
            "Operations per impact, flights and searches included, counted by running the "
            "solver's own code on numbers that count. Limit: the time these operations take when "
            "all are independent and all vector lanes are full. A root search is a chain of "
            "dependent steps with branches, so a single ball cannot reach the limit. 104 balls go "
            "side by side; what that computes beside a single ball's operations is not counted."
        ],
    )


def _per_impact(seconds: Sample, drops: int, impacts: float) -> Sample:
    """Nanoseconds per impact from seconds for all drops."""
    return seconds.map(lambda s: s * 1e9 / (drops * impacts))


def least_time(count: dict[str, float], times: dict[str, Sample]) -> float:
    """Nanoseconds that so many operations take at the machine's measured best."""
    pairs = 0.5 * (count["add"] + count["multiply"])
    return (
        pairs * times["separate"].median
        + count["divide"] * times["divide"].median
        + count["root"] * times["root"].median
    )


def _sizes(section: Section, effort: Effort) -> None:
    """How the cost grows with the path (rows) and with the board alone (pegs)."""
    rows = (8, 16, 32) if effort.quick else (8, 16, 24, 32, 48, 64)
    widths = (16, 32) if effort.quick else (16, 32, 64, 128, 256, 626)
    by_rows = {str(n): scenes.lattice(n, 33, scenes.FULL) for n in rows}
    by_pegs = {}
    for width in widths:
        board = scenes.lattice(16, width, scenes.FULL)  # even: a peg row is centred alike
        by_pegs[f"{len(board.pegs):,}"] = board
    section.data["rows"] = _growth(
        section, effort, by_rows, "Cost against rows, 33 columns", "rows"
    )
    section.data["pegs"] = _growth(
        section, effort, by_pegs, "Cost against pegs, 16 rows: the same path", "pegs"
    )
    section.plots["bench-growth.png"] = lambda path: _plot_growth(section.data, path)


def _growth(
    section: Section, effort: Effort, boards: dict[str, Board], title: str, what: str
) -> dict[str, Any]:
    drops = effort.size(8_192, 256)
    impacts = {name: _impacts(board, drops) for name, board in boards.items()}
    jobs = {name: timed(_many(board, drops, 1)) for name, board in boards.items()}
    times = in_turns(jobs, effort.rounds, lambda: effort.step(what))
    per_impact = {name: _per_impact(sample, drops, impacts[name]) for name, sample in times.items()}
    first = per_impact[next(iter(boards))]
    section.tables.append(
        Table(
            title,
            [what, "impacts a drop", "drops/s", "ns an impact", f"to {next(iter(boards))}"],
            [
                [
                    name,
                    f"{impacts[name]:.1f}",
                    spread(times[name].map(lambda s: drops / s), "{:,.0f}"),
                    spread(per_impact[name], "{:,.0f}"),
                    f"{per_impact[name].over(first).median:.2f}",
                ]
                for name in boards
            ],
            [f"One core, {drops:,} drops a round; last column: ratio of ns, median of the rounds."],
        )
    )
    return {
        "count": [int(name.replace(",", "")) for name in boards],
        "drops_per_second": [drops / times[name].median for name in boards],
        "ns_per_impact": [per_impact[name].to_dict() for name in boards],
    }


def _plot_growth(data: dict[str, Any], path: str) -> None:
    from benchmarks.harness import plots

    plots.growth(data["rows"], data["pegs"], path)


def _starts(section: Section, effort: Effort) -> None:
    """Loading each solver, and whole processes."""
    runs = effort.size(5, 1)
    cold = [Sample(tuple(s)) for s in zip(*_cold_starts(effort.size(3, 1)), strict=True)]
    effort.step("cold start")
    command = [sys.executable, "-m", "app.cli", "drop", "triangle-16", "--seed", "42", "--json"]
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
    """Seconds until a server takes drops that makes its ledger first, and its megabytes then."""
    began = time.perf_counter()
    with serving() as served:
        return time.perf_counter() - began, served.resident / 1e6


def _cold_starts(count: int) -> list[list[float]]:
    """Seconds from the first import to each of COLD; count runs."""
    told = [_run([sys.executable, "-c", COLD_PROGRAM]).split() for _ in range(count)]
    return [[float(seconds) for seconds in each] for each in told]


def _run(command: list[str]) -> str:
    """Its output. Python keeps bytecode, as it does of an installed program, whatever is set."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
        env=kept,
    ).stdout
