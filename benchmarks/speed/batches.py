"""Long batches: workers compared with threads, the scheduler's cost, estimates for more workers."""

import gc
import resource
import statistics
import sys
import time
from functools import partial
from typing import Any, Final

from benchmarks.harness import machine
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from plinko.engine import Board
from plinko.engine.batches.block import block_of
from plinko.engine.batches.cluster import together
from plinko.engine.batches.job import Job
from plinko.engine.batches.tally import Tally
from plinko.engine.batches.workers import Here, Workers, workers_at
from plinko.engine.drops.digest import BLOCK
from plinko.engine.parameters import Exact

BOARD: Final = "triangle-16"

SLICES: Final = 8
"""Slices of the drops, which threads and workers compute in turns, so that a slow minute of the
machine affects both."""

EMPTY: Final = 4000
"""Calls that compute nothing, which measure the cost of a call."""

MANY: Final = (10, 100, 1000, 10_000)
"""Numbers of workers, of one thread each, in the table of estimates."""


def run(effort: Effort) -> Section:
    """Efficiency of one local worker per core, and estimates for more workers."""
    section = Section("batches")
    cores = machine.cores()
    drops = effort.size(10_000_000, SLICES * 1000) // SLICES
    with workers_at(f"local:{cores}") as workers:
        pairs = []
        for number in range(SLICES):
            job = Job(Board.preset(BOARD), Exact(), number * drops, drops)
            pairs.append(_pair(job, Here(cores), workers, threads_first=number % 2 == 0))
            effort.step("batches")
        wall, processor = _cost_of_a_call(workers, EMPTY if not effort.quick else 40)
        memory = max(found for _, found in workers.compute(_memory, range(40 * cores)))
    threads = sum(here for here, _ in pairs)
    elsewhere = sum(there for _, there in pairs)
    ratio = statistics.median(here / there for here, there in pairs)
    section.data = {
        "drops": drops * SLICES,
        "cores": cores,
        "threads_seconds": threads,
        "cluster_seconds": elsewhere,
        "efficiency": ratio,
        "efficiency_least": min(here / there for here, there in pairs),
        "efficiency_most": max(here / there for here, there in pairs),
        "call_seconds": wall,
        "call_processor_seconds": processor,
        "worker_bytes": memory,
    }
    block = threads * cores * BLOCK / (drops * SLICES)
    section.tables += [_measured(section.data), _more(block, max(wall, processor))]
    return section


def _pair(job: Job, here: Workers, there: Workers, *, threads_first: bool) -> tuple[float, float]:
    """Seconds of a job by threads and by workers; raises AssertionError if their digests differ."""
    order = (here, there) if threads_first else (there, here)
    found = {workers: _seconds(job, workers) for workers in order}
    if found[here][1] != found[there][1]:
        raise AssertionError(f"digests {found[here][1]} and {found[there][1]} differ")
    return found[here][0], found[there][0]


def _seconds(job: Job, workers: Workers) -> tuple[float, str | None]:
    gc.collect()
    tally = Tally(job)
    began = time.perf_counter()
    for _, block in workers.compute(partial(block_of, job), tally.missing()):
        tally.add(block)
    return time.perf_counter() - began, tally.digest


def _cost_of_a_call(workers: Workers, calls: int) -> tuple[float, float]:
    """Wall seconds of an empty call, and processor seconds of the scheduler and client for it."""
    for _ in workers.compute(_nothing, range(workers.at_once)):
        pass
    began, spent = time.perf_counter(), time.process_time()
    for _ in workers.compute(_nothing, range(calls)):
        pass
    return (time.perf_counter() - began) / calls, (time.process_time() - spent) / calls


def _nothing(number: int, _threads: int) -> int:
    return number


def _memory(_number: int, _threads: int) -> int:
    """This worker's largest resident memory, bytes."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def _measured(data: dict[str, Any]) -> Table:
    rows = [
        ["threads of one process", f"{data['threads_seconds']:.1f} s"],
        ["local workers", f"{data['cluster_seconds']:.1f} s"],
        [
            "efficiency",
            f"{data['efficiency']:.3f} ({data['efficiency_least']:.3f} to "
            f"{data['efficiency_most']:.3f})",
        ],
        ["a call of nothing, by the clock", f"{1e3 * data['call_seconds']:.2f} ms"],
        ["of it in scheduler and client", f"{1e3 * data['call_processor_seconds']:.2f} ms"],
        ["memory of a worker, at most", f"{data['worker_bytes'] / 1e6:.0f} MB"],
    ]
    title = f"A batch on {data['cores']} cores: {data['drops']:,} drops of {BOARD}"
    return Table(
        title,
        ["what", "measured"],
        rows,
        [
            "All of these are measured. Threads and workers take slices of the drops in turns; the "
            "efficiency is the median of the slices' ratios, with the least and the largest, and "
            "every slice has the same digest of both. Scheduler and client are one process here, "
            "and share the cores with the workers."
        ],
    )


def _more(block: float, call: float) -> Table:
    """How many workers one scheduler can feed, from the time of a block and the cost of a call."""
    rows = []
    for workers in MANY:
        needed, given = workers / (block * together(workers)), 1.0 / call
        share = min(1.0, given / needed)
        rows.append(
            [
                f"{workers:,}",
                f"{together(workers)}",
                f"{needed:,.1f}",
                f"{given:,.0f}",
                f"{share:.2f}",
                f"{share * workers * BLOCK / block:,.0f}",
            ]
        )
    return Table(
        "More workers than there are here",
        [
            "workers",
            "blocks a call",
            "calls/s they take",
            "calls/s there are",
            "efficiency",
            "drops/s",
        ],
        rows,
        [
            f"None of these rows is measured: they follow from two that are, a block's "
            f"{1e3 * block:.0f} ms of a core and a call's {1e3 * call:.2f} ms. Cores are taken to "
            "be as fast as here and the network to be no bound: a block's result is some 300 bytes "
            "and its request 10 kB."
        ],
    )
