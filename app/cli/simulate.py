"""`plinko simulate`: many seeded drops and what came of them."""

import math
import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

import click

from app.cli import common

if TYPE_CHECKING:
    from click._termui_impl import ProgressBar

    from engine import Board, DropBatch

CHUNK = 1 << 18  # drops held at once: some 10 MB, and enough work for every core
BAR_WIDTH = 40  # characters of the longest bar of the printed histogram


@click.command(name="simulate", short_help="Drop many balls and count where they land.")
@common.board_argument
@click.option("--drops", type=click.IntRange(min=1), required=True, help="How many.")
@click.option("--seed", default="0", show_default=True, help="Of the first; then one more each.")
@common.solver_options
@click.option("--threads", type=click.IntRange(min=1), help="Default: every core.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    drops: int,
    seed: str,
    solver: str,
    dt: float | None,
    substeps: int | None,
    correction: float | None,
    threads: int | None,
    as_json: bool,
) -> None:
    """Drop many balls on BOARD, seeds FIRST to FIRST + N - 1, and count where they land.

    The digest is over all outcomes in the order of the seeds: the same however the work was split.
    The time is that of the drops alone, without start-up and compilation.
    """
    how = common.read_solver(solver, dt, substeps, correction)
    first = common.read_seed(seed)
    common.read_seed(str(first + drops - 1))
    tally = _run(common.load_board(board), first, drops, how | {"threads": threads})
    if as_json:
        common.print_json(tally.summary())
    else:
        _print(tally, first)


class _Tally:
    """What is kept of the drops: sums and a running digest, so that memory does not grow."""

    def __init__(self, start: "DropBatch") -> None:
        """Count nothing yet; `start` says which board and solver."""
        import numpy as np

        from engine.digest import OutcomesDigest

        self.board = start.board
        self.solver = start.solver
        self.seconds = 0.0
        self.drops = 0
        self._histogram = np.zeros_like(start.histogram)
        self._unsettled = 0
        self._impacts = 0
        self._durations: list[float] = []
        self._digest = OutcomesDigest(start.board.digest, start.solver)

    def add(self, batch: "DropBatch", seconds: float) -> None:
        """Count the drops of the next seeds, which took `seconds`."""
        self.seconds += seconds
        self.drops += len(batch)
        self._histogram += batch.histogram
        self._unsettled += batch.unsettled
        self._impacts += int(batch.impact_count.sum())
        # fsum is exact: the mean has the same bits on every machine.
        self._durations = [math.fsum((*self._durations, *batch.duration))]
        self._digest.add(batch.bin, batch.duration, batch.impact_count, batch.x_end)

    def summary(self) -> dict[str, Any]:
        """The fields of `--json`. Means are over all drops, unsettled ones included."""
        return {
            "board_digest": self.board.digest,
            "drops": self.drops,
            "histogram": self._histogram.tolist(),
            "unsettled": self._unsettled,
            "mean_duration": self._durations[0] / self.drops,
            "mean_impacts": self._impacts / self.drops,
            "seconds": self.seconds,
            "drops_per_second": self.drops / self.seconds,
            "digest": self._digest.hexdigest(),
        }


def _run(board: "Board", first: int, drops: int, options: dict[str, Any]) -> _Tally:
    from engine import drop_many

    # The first drop compiles what is not compiled yet; it is not timed.
    tally = _Tally(drop_many(board, range(first, first + 1), **options))
    with _progress(drops) as bar:
        while tally.drops < drops:
            done = tally.drops
            seeds = range(first + done, first + min(done + CHUNK, drops))
            start = time.perf_counter()
            batch = drop_many(board, seeds, progress=_after(done, bar), **options)
            tally.add(batch, time.perf_counter() - start)
    return tally


def _after(done: int, bar: "ProgressBar[int] | None") -> Callable[[int], None] | None:
    """A callback for a chunk that starts when `done` drops are done."""
    if bar is None:
        return None
    return lambda more: bar.update(done + more - bar.pos)


def _progress(drops: int) -> "AbstractContextManager[ProgressBar[int] | None]":
    """A progress bar on stderr where somebody sees it, nothing elsewhere."""
    if not sys.stderr.isatty():
        return nullcontext()
    return click.progressbar(length=drops, label="drops", file=sys.stderr)


def _print(tally: _Tally, first: int) -> None:
    summary, pays = tally.summary(), tally.board.bins.multipliers
    drops, histogram = tally.drops, summary["histogram"]
    longest = max(histogram) or 1
    click.echo("bin      pays       drops    share")
    for number, (count, pay) in enumerate(zip(histogram, pays, strict=True)):
        bar = "#" * round(BAR_WIDTH * count / longest)
        click.echo(f"{number:3} {pay:9g} {count:11} {count / drops:8.3%}  {bar}".rstrip())
    # An unsettled drop gives its stake back.
    paid = math.fsum(n * pay for n, pay in zip(histogram, pays, strict=True)) + summary["unsettled"]
    click.echo()
    common.print_fields(
        {
            "board": tally.board.name,
            "seeds": f"{first} to {first + drops - 1}",
            "solver": common.describe_solver(tally.solver),
            "unsettled": str(summary["unsettled"]),
            "return": f"{paid / drops:.3%}",
            "mean drop": f"{summary['mean_duration']:.4f} s, {summary['mean_impacts']:.2f} impacts",
            "speed": f"{summary['drops_per_second']:,.0f} drops/s, {summary['seconds']:.3f} s",
            "digest": summary["digest"],
        }
    )
