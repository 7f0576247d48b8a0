"""The speed of batches: one ball at a time in WebAssembly, in lanes as native code, and in a page.

For comparison: pymunk, and the time of the counted operations at the machine's highest speed.
"""

import time
from collections.abc import Callable
from typing import Any

from benchmarks.contestants.chipmunk import Chipmunk
from benchmarks.contestants.common import AbsentError
from benchmarks.harness import machine
from benchmarks.harness.clock import Job, Sample, in_turns, seconds_of, timed
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.scenes import boards as scenes
from benchmarks.speed import arithmetic, operations, page_drops
from benchmarks.speed.batch_code import batch_by
from plinko.engine import Board, drop_many
from plinko.engine.exact.lanes import trial

DROPS = 16_384
"""Drops per round; pymunk plays a hundredth of them."""

STEP = 1 / 240
"""pymunk's time step, s."""

BOARDS: dict[str, Board] = {
    "triangle-16": Board.preset("triangle-16"),
    "triangle-8": Board.preset("triangle-8"),
    "classic": Board.preset("classic"),
    "galton": Board.preset("galton"),
    "12 rows, no friction, no drag": scenes.triangle(12, scenes.PLAIN),
}


def run(effort: Effort) -> Section:
    section = Section("lanes")
    drops = effort.size(DROPS, 512)
    times, impacts = _measured(section, drops, effort)
    section.tables += [
        _speed_table(times, drops, effort.rounds),
        _limit_table(times, impacts, drops, effort),
        _arithmetic_table(times),
    ]
    page_drops.compare(section, effort)
    section.data["seconds"] = {name: sample.to_dict() for name, sample in times.items()}
    return section


def _measured(
    section: Section, drops: int, effort: Effort
) -> tuple[dict[str, Sample], dict[str, float]]:
    """Seconds of each contestant on each board, and each board's impacts per drop."""
    jobs: dict[str, Job] = dict(arithmetic.jobs(effort.size(arithmetic.SWEEPS, 500)))
    impacts = {}
    native = trial.trusted()
    if not native:
        section.absent.append("native code: this machine runs none")
    for name, board in BOARDS.items():
        batch = drop_many(board, range(drops))
        xs = batch.x_start
        impacts[name] = float(batch.impact_count.mean())
        jobs[f"{name}/alone"] = _processor_time(batch_by(board, xs, trial.NONE))
        if native:
            jobs[f"{name}/lanes"] = _processor_time(batch_by(board, xs, native))
        cores = machine.cores()
        jobs[f"{name}/cores"] = timed(_many(board, cores * drops, cores))
        try:
            jobs[f"{name}/pymunk"] = _pymunk(board, xs[: max(drops // 100, 20)], drops)
        except AbsentError as absent:
            section.absent.append(str(absent))
    return in_turns(jobs, effort.rounds, lambda: effort.step("lanes")), impacts


def _processor_time(work: Callable[[], object]) -> Job:
    """A job that returns processor seconds, so that other load on the machine does not count."""
    return lambda: seconds_of(work, time.process_time)


def _many(board: Board, drops: int, threads: int) -> Callable[[], object]:
    return lambda: drop_many(board, range(drops), threads=threads)


def _pymunk(board: Board, xs: Any, drops: int) -> Job:
    """Seconds for `drops` drops, scaled up from the few that are played."""
    contestant = Chipmunk()
    job = _processor_time(lambda: contestant.seconds(board, xs, STEP))
    return lambda: job() * drops / len(xs)


def _speed_table(times: dict[str, Sample], drops: int, rounds: int) -> Table:
    rows = []
    for name in BOARDS:
        own = {who: times.get(f"{name}/{who}") for who in ("alone", "lanes", "pymunk")}
        scalar = times[f"{name}/alone"]
        best = own["lanes"] or scalar
        rows.append(
            [
                name,
                *(_speed(own[who], drops) for who in ("alone", "lanes")),
                spread(scalar.over(best), "{:.2f}"),
                _speed(times[f"{name}/cores"], machine.cores() * drops),
                "" if own["pymunk"] is None else spread(own["pymunk"].over(best), "{:,.0f}"),
            ]
        )
    return Table(
        "Batches: drops per second, one core",
        [
            "board", "one by one, WebAssembly", "lanes, native", "ratio",
            f"{machine.cores()} cores", "times pymunk",
        ],
        rows,
        [
            f"Median (smallest to largest) of {rounds} round(s) of {drops:,} drops in turns, by "
            "processor time but for that of all cores, which is what passes. Ratios are medians of "
            "the rounds' ratios, the first of lanes to one ball after the other. All "
            "give the same bits. pymunk: at 1/240 s a step, the same boards."
        ],
    )  # fmt: skip


def _speed(sample: Sample | None, drops: int) -> str:
    return "" if sample is None else spread(sample.map(lambda s: drops / s), "{:,.0f}")


def _limit_table(
    times: dict[str, Sample], impacts: dict[str, float], drops: int, effort: Effort
) -> Table:
    rows = []
    for name, board in BOARDS.items():
        count = operations.count_apart(board.to_json(), effort.size(100, 2))
        best = times.get(f"{name}/lanes") or times[f"{name}/alone"]
        spent = best.map(lambda s, many=drops * impacts[name]: s * 1e9 / many)  # type: ignore[misc]
        limit = least_time(count, times)
        rows.append(
            [name, f"{impacts[name]:.1f}", spread(spent, "{:,.0f}"), f"{limit:.0f}",
             f"{spent.median / limit:.1f}"]
        )  # fmt: skip
    return Table(
        "Batches: nanoseconds per impact, one core",
        ["board", "impacts a drop", "ns", "limit", "times the limit"],
        rows,
        [
            "Limit: what the operations of one ball take, flights and searches included, when all "
            "are independent and fill all vector lanes, by each operation's shortest time. They "
            "are counted by running the solver's own code on numbers that count. A root search is "
            "a chain of dependent steps with branches, so one ball alone cannot reach the limit."
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


def least_time(count: dict[str, float], times: dict[str, Sample]) -> float:
    """Nanoseconds of `count` operations if each takes its shortest measured time."""
    pairs = 0.5 * (count["add"] + count["multiply"])
    return (
        pairs * times["separate"].low
        + count["divide"] * times["divide"].low
        + count["root"] * times["root"].low
    )
