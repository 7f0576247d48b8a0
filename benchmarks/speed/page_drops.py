"""The same drops by each machine code that the kernels become: a page's, the server's, numba's."""

import contextlib
import shutil
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.contestants.node import NodeProcess
from benchmarks.harness.clock import Job, Sample, in_turns, seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table, spread
from engine import Board, drop_many
from engine.drops.batch import DropBatch
from engine.exact.trace import trace_many

BOARDS = ("triangle-8", "triangle-16", "classic")
DROPS = 32_768
"""In a round: half a second of each, or more."""


def compare(section: Section, effort: Effort) -> None:
    """A table of drops a second on one core: a page's own code, the artifact by wasmtime, numba."""
    if shutil.which("node") is None or find_spec("numba") is None:
        section.absent.append("a page's drops beside numba's: Node.js and numba are needed")
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
            "A page beside the server and numba: drops per second, one core",
            ["board", "page (V8)", "artifact (wasmtime)", "numba", "page to numba"],
            rows,
            [
                f"Median (smallest to largest) of {effort.rounds} round(s) of {drops:,} drops in "
                "turns; the ratio is the median of the rounds' ratios. The page's are what its "
                "worker computes, on Node.js, board and seeds read by its own code. Bins and ends "
                "were compared, and are the same to the last bit. Aim: half of numba's."
            ],
        )
    )


def _times(board: Board, drops: int, page: NodeProcess, effort: Effort) -> dict[str, Sample]:
    """Seconds of each; AssertionError where one's bits differ."""
    true = drop_many(board, range(drops), threads=1)
    form = board.to_dict()

    def in_page() -> float:
        found = page.ask({"board": form, "drops": drops})
        _same(true, np.array(found["bins"]), np.array(found["x_ends"]))
        return float(found["seconds"])

    def here() -> float:
        batches: list[DropBatch] = []
        seconds = seconds_of(lambda: batches.append(drop_many(board, range(drops), threads=1)))
        _same(true, batches[0].bin, batches[0].x_end)
        return seconds

    def by_numba() -> float:
        with _numba():
            return here()

    jobs: dict[str, Job] = {"page": in_page, "wasmtime": here, "numba": by_numba}
    return in_turns(jobs, effort.rounds, lambda: effort.step(f"page, {board.name}"))


def _same(true: DropBatch, bins: Any, ends: Any) -> None:
    if bins.tolist() != true.bin.tolist() or ends.tolist() != true.x_end.tolist():
        raise AssertionError("not the same drops")


@contextlib.contextmanager
def _numba() -> Iterator[None]:
    """Within it batches run by what numba compiles of the same kernel."""
    from engine.jit.kernel_compiler import compiled

    kernel: Any = trace_many
    artifact = kernel.machine_code
    kernel.machine_code = compiled(kernel)
    try:
        yield
    finally:
        kernel.machine_code = artifact


def _row(name: str, drops: int, times: dict[str, Sample]) -> list[str]:
    speeds = {who: sample.map(lambda seconds: drops / seconds) for who, sample in times.items()}
    return [
        name,
        *(spread(speeds[who], "{:,.0f}") for who in ("page", "wasmtime", "numba")),
        spread(speeds["page"].over(speeds["numba"]), "{:.2f}"),
    ]
