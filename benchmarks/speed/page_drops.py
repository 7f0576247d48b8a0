"""The same drops by the page's code, by wasmtime and by native code."""

import contextlib
import shutil
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.contestants.node import NodeProcess
from benchmarks.harness.clock import Job, Sample, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from benchmarks.speed.batch_code import batch_by
from plinko.engine import Board, drop_many
from plinko.engine.drops.batch import DropBatch
from plinko.engine.exact.lanes import trial
from plinko.engine.exact.lanes.trace import Code
from plinko.engine.exact.outcome import Results

BOARDS = ("triangle-8", "triangle-16", "classic")
DROPS = 32_768
"""Drops per round, which take each contestant half a second or more."""


def compare(section: Section, effort: Effort) -> None:
    """Add a table of drops per second on one core."""
    if shutil.which("node") is None or not trial.trusted():
        section.absent.append("a page's drops: Node.js and native code are needed")
        return
    drops = effort.size(DROPS, 500)
    rows = []
    with contextlib.closing(NodeProcess("page.mjs")) as page:
        for name in BOARDS:
            times = _times(Board.preset(name), drops, page, effort)
            rows.append(_row(name, drops, times))
            section.data.setdefault("page", {})[name] = {
                who: sample.to_dict() for who, sample in times.items()
            }
    section.tables.append(
        Table(
            "A page beside wasmtime and native code: drops per second, one core",
            ["board", "page (V8)", "wasmtime", "native", "page to wasmtime"],
            rows,
            [
                f"Median (smallest to largest) of {effort.rounds} round(s) of {drops:,} drops in "
                "turns; the ratio is the median of the rounds' ratios. The page's are what its "
                "worker computes, on Node.js, board and seeds read by its own code. Bins and ends "
                "were compared, and are the same to the last bit."
            ],
        )
    )


def _times(board: Board, drops: int, page: NodeProcess, effort: Effort) -> dict[str, Sample]:
    """Seconds of each contestant; raises AssertionError if its results differ in any bit."""
    true = drop_many(board, range(drops), threads=1)
    form = board.to_dict()

    def in_page() -> float:
        found = page.ask({"board": form, "drops": drops})
        _same(true, np.array(found["bins"]), np.array(found["x_ends"]))
        return float(found["seconds"])

    def by(code: Mapping[str, Code]) -> Job:
        work = batch_by(board, true.x_start, code)

        def run() -> float:
            found: list[Results] = []
            seconds = seconds_of(lambda: found.append(work()))
            _same(true, found[0].bins, found[0].x_ends)
            return seconds

        return run

    jobs: dict[str, Job] = {
        "page": in_page, "wasmtime": by(trial.NONE), "native": by(trial.trusted()),
    }  # fmt: skip
    return in_turns(jobs, effort.rounds, lambda: effort.step(f"page, {board.name}"))


def _same(true: DropBatch, bins: Any, ends: Any) -> None:
    if bins.tolist() != true.bin.tolist() or ends.tolist() != true.x_end.tolist():
        raise AssertionError("bins or ends differ from those of drop_many")


def _row(name: str, drops: int, times: dict[str, Sample]) -> list[str]:
    speeds = {who: sample.map(lambda seconds: drops / seconds) for who, sample in times.items()}
    return [
        name,
        *(spread(speeds[who], "{:,.0f}") for who in ("page", "wasmtime", "native")),
        spread(speeds["page"].over(speeds["wasmtime"]), "{:.2f}"),
    ]
