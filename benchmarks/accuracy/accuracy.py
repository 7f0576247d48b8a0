"""Run time against error: our solvers, a tutorial's engine and the popular engines.

The true paths come from the mpmath oracle. Every contestant plays the same boards from the same
starts.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from benchmarks.accuracy import energy
from benchmarks.accuracy.histogram import histograms
from benchmarks.accuracy.reference import AFTER, Reference, reference
from benchmarks.contestants import node
from benchmarks.contestants.box2d import Box2d
from benchmarks.contestants.chipmunk import Chipmunk
from benchmarks.contestants.common import AbsentError, Contestant, Floats
from benchmarks.contestants.naive import Naive
from benchmarks.contestants.ours import Exact, Stepped
from benchmarks.harness.clock import Job, Sample, in_turns
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, length
from benchmarks.scenes import boards as scenes
from plinko.engine import Board

RATES = (60, 240, 960)
"""Steps per second."""

QUICK_RATES = (60, 240)

BOARDS = {
    "plain-12": ("12 rows, no friction, no drag", 12, scenes.PLAIN),
    "trial-16": ("16 rows, drag, friction and spin", 16, scenes.FULL),
}
"""Title, rows and physics of each board."""

HEADING = "Error against the oracle: "

COLUMNS = (
    "contestant, dt in s",
    *(f"after impact {n}" for n in AFTER),
    "same bin, decidable",
    "same bin, all",
    "deepest overlap",
    "drops/s",
)


def plot_of(key: str) -> str:
    return f"bench-accuracy-{key}.png"


def run(effort: Effort) -> Section:
    section = Section("accuracy")
    boards = {key: scenes.triangle(rows, tuning) for key, (_, rows, tuning) in BOARDS.items()}
    rates = QUICK_RATES if effort.quick else RATES
    with contestants(section, effort) as everyone:
        for key, board in boards.items():
            title = BOARDS[key][0]
            truth = reference(board, effort.size(128, 4), effort)
            entries = list(_entries(everyone, rates))
            speeds = _speeds(board, truth.xs, entries, effort)
            section.data[key] = _errors(truth, entries, speeds, effort)
            section.tables.append(_table(title, truth, section.data[key]))
            section.plots[plot_of(key)] = _plotter(title, section.data[key])
        histograms(section, boards["trial-16"], everyone, effort)
        energy.elastic(section, everyone, rates, effort)
        energy.bounces(section, everyone, rates, effort)
    return section


@contextmanager
def contestants(section: Section, effort: Effort) -> Iterator[list[Contestant]]:
    """All contestants that are installed; the others are noted in the section as absent."""
    found: list[Contestant] = [Exact(), Stepped(), Naive()]
    for kind in (Chipmunk, Box2d):
        try:
            found.append(kind())
        except AbsentError as error:
            section.absent.append(str(error))
    helpers: list[node.NodeEngine] = []
    if effort.node:
        try:
            # Only check: packages that are missing are reported, not installed.
            node.check()
            helpers = [node.NodeEngine(module) for module in node.ENGINES]
        except AbsentError as error:
            section.absent.append(str(error))
    try:
        yield [*found, *helpers]
    finally:
        for helper in helpers:
            helper.close()


Entry = tuple[str, Contestant, int]
"""Label, contestant, steps per second (0 for one without steps)."""


def _entries(everyone: Sequence[Contestant], rates: Sequence[int]) -> Iterator[Entry]:
    for contestant in everyone:
        for rate in rates if contestant.stepped else (0,):
            yield label(contestant, rate), contestant, rate


def label(contestant: Contestant, rate: int) -> str:
    """The contestant's name, with its time step if it has one."""
    return f"{contestant.name} 1/{rate}" if rate else contestant.name


def step_of(rate: int) -> float:
    """dt in s; contestants without steps are sampled 240 times a second."""
    return 1.0 / (rate or 240)


def _speeds(
    board: Board, xs: Floats, entries: Sequence[Entry], effort: Effort
) -> dict[str, Sample]:
    """Drops per second of each entry, in turns."""
    some = np.resize(xs, effort.size(40, 2))
    many = np.resize(xs, effort.size(4096, 64))  # compiled contestants finish few drops too soon

    def job(contestant: Contestant, rate: int) -> Job:
        compiled = isinstance(contestant, Exact | Naive)
        starts = many[: 1 + len(many) * 60 // (8 * rate)] if compiled and rate else many
        starts = starts if compiled else some
        return lambda: len(starts) / contestant.seconds(board, starts, step_of(rate))

    jobs = {name: job(contestant, rate) for name, contestant, rate in entries}
    rounds = min(effort.rounds, 5)
    return in_turns(jobs, rounds, lambda: effort.step("drops per second"))


def _errors(
    truth: Reference, entries: Sequence[Entry], speeds: dict[str, Sample], effort: Effort
) -> dict[str, Any]:
    rows: dict[str, Any] = {}
    for name, contestant, rate in entries:
        dt = step_of(rate)
        times = np.nan_to_num(truth.times)
        longest = 1.25 * float(truth.durations.max())
        seen = contestant.observe(truth.board, truth.xs, dt, times, longest)
        error = np.hypot(*np.moveaxis(seen.positions - truth.positions, -1, 0))
        same = seen.bins == truth.bins
        rows[name] = {
            "contestant": contestant.name,
            "rate": rate,
            "error": np.nanmedian(error, axis=0).tolist(),
            "worst": np.nanmax(error, axis=0).tolist(),
            "same_bin": float(same.mean()),
            "same_bin_decidable": int(same[truth.decidable].sum()),
            "deepest": seen.deepest,
            "drops_per_second": speeds[name].to_dict(),
        }
        effort.step(name)
    return {
        "drops": len(truth.xs),
        "decidable": int(truth.decidable.sum()),
        "after": list(AFTER),
        "floor": np.nanmedian(truth.floor, axis=0).tolist(),
        "entries": rows,
    }


def _table(title: str, truth: Reference, data: dict[str, Any]) -> Table:
    rows = [
        [
            name,
            *(length(error) for error in entry["error"]),
            f"{entry['same_bin_decidable']}/{data['decidable']}",
            f"{entry['same_bin']:.0%}",
            length(entry["deepest"]) if entry["deepest"] > 1e-15 else "0",
            f"{entry['drops_per_second']['median']:,.0f}",
        ]
        for name, entry in data["entries"].items()
    ]
    floor = ["(one rounding of the start)", *(length(x) for x in data["floor"]), "", "", "", ""]
    return Table(
        HEADING + title,
        COLUMNS,
        [*rows, floor],
        [
            f"Median position error over {len(truth.xs)} drops midway between the impact and the "
            "next. Drops that end in the oracle's bin: among those whose bin double precision can "
            "decide (four roundings of a coordinate, 2^-50 m each, leave it as it is when they "
            "grow as the oracle's path does with its impacts shaken), and among all; the others "
            "are chaos, where agreement is chance for everyone. Deepest overlap of a ball with a "
            "peg at the end of any step; drops per second on one core, median of the rounds. "
            "Last row: the median growth of half a unit in the last place of the start, the "
            "least error that can be asked of any program in double precision."
        ],
    )


def _plotter(title: str, data: dict[str, Any]) -> Any:
    def draw(path: str) -> None:
        from benchmarks.accuracy import work_precision_plot

        work_precision_plot.work_precision(title, data, path)

    return draw
