"""How late a server's ticks are while clients request pictures all the time."""

import contextlib
import threading
import urllib.error
import urllib.request
from collections import Counter
from collections.abc import Iterator
from itertools import count
from typing import Any

from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from benchmarks.serving import stream
from benchmarks.serving.process import OPTIONS, Served, can_watch, serving

ASKERS = 2
CLIENTS = 20  # clients that watch the room meanwhile
BOARD = "triangle-16"

QUIET, BUSY = "nobody asks for a picture", f"{ASKERS} clients ask for GIFs all the time"


def ticks(section: Section, effort: Effort) -> None:
    """Measure the ticks of one server, in turns with and without requests for GIFs."""
    if not can_watch():
        section.absent.append("ticks while pictures are drawn: needs /proc, as on Linux")
        return
    seconds = float(effort.size(10, 1))
    turns = effort.size(3, 1)
    found: dict[str, Counter[float]] = {QUIET: Counter(), BUSY: Counter()}
    drawn = 0
    seeds = count()
    with serving(OPTIONS) as server:
        for _ in range(turns):
            for name, buckets in found.items():
                effort.step(name)
                with _asking(server, seeds if name == BUSY else None) as answers:
                    buckets.update(_lateness(server, seconds))
                drawn += len(answers)
    data = {name: _figures(sorted(buckets.items())) for name, buckets in found.items()}
    data[BUSY]["gifs_per_second"] = drawn / (turns * seconds)
    section.data["ticks"] = data
    section.tables.append(_table(data, turns, seconds))


def _lateness(server: Served, seconds: float) -> dict[float, float]:
    """Cumulative number of ticks by bucket, while clients watch a room with balls."""
    from benchmarks.load.client import room_url
    from benchmarks.load.generator import Load, run

    window = stream.Window(server)
    load = Load(room_url(server.address, "main", "snapshots"), CLIENTS, drops=stream.DROPS)
    load.on_count = window.begin
    run(load, seconds)
    window.end()
    return dict(window.lateness())


@contextlib.contextmanager
def _asking(server: Served, seeds: "Iterator[int] | None") -> Iterator[list[int]]:
    """Let clients request one GIF after another; yields the list of the sizes received."""
    over = threading.Event()
    answers: list[int] = []

    def ask() -> None:
        assert seeds is not None
        while not over.is_set():
            url = f"{server.address}/api/v1/drops/{BOARD}/{next(seeds)}.gif"
            try:
                with urllib.request.urlopen(url, timeout=60.0) as answer:
                    answers.append(len(answer.read()))
            except urllib.error.HTTPError as error:
                if error.code != 503:  # the queue is full
                    raise

    threads = [threading.Thread(target=ask) for _ in range(ASKERS if seeds else 0)]
    for thread in threads:
        thread.start()
    try:
        yield answers
    finally:
        over.set()
        for thread in threads:
            thread.join()


def _figures(buckets: list[tuple[float, float]]) -> dict[str, Any]:
    return {
        "ticks": buckets[-1][1],
        "late_p50": stream.quantile(buckets, 0.5),
        "late_p99": stream.quantile(buckets, 0.99),
        "in_time": stream.share_within(buckets, stream.LATE),
    }


def _table(data: dict[str, dict[str, Any]], turns: int, seconds: float) -> Table:
    rows = [
        [
            name,
            f"{entry['ticks']:,.0f}",
            f"{1e3 * entry['late_p50']:.2f}",
            f"{1e3 * entry['late_p99']:.2f}",
            f"{entry['in_time']:.2%}",
            f"{entry.get('gifs_per_second', 0.0):.1f}",
        ]
        for name, entry in data.items()
    ]
    return Table(
        "Ticks while pictures are drawn",
        ["meanwhile", "ticks", "late p50, ms", "late p99, ms", "ticks within 4 ms", "GIFs/s"],
        rows,
        [
            f"One server, {turns} time(s) {seconds:.0f} s of each in turns, a room at 60 Hz with "
            f"some 50 balls and {CLIENTS} clients; each GIF is of another seed of {BOARD}, drawn "
            "in a worker's thread. Late: from when a tick was due until it began, by the server's "
            "own histogram. All of it, clients too, shares the machine's cores."
        ],
    )
