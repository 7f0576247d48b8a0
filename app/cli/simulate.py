"""`plinko simulate`: many seeded drops and what came of them."""

import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

import click

from app.cli import common

if TYPE_CHECKING:
    from engine import Board, DropBatch

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
    where = common.load_board(board)
    many, seconds = _run(where, first, drops, how, threads)
    summary = _summarise(many, seconds)
    if as_json:
        common.print_json(summary)
    else:
        _print(many, first, summary)


def _run(
    board: "Board", first: int, drops: int, how: common.Options, threads: int | None
) -> tuple["DropBatch", float]:
    import numpy as np

    from engine import drop_many

    seeds = np.arange(drops, dtype=np.uint64) + np.uint64(first)
    options = how | {"threads": threads}
    drop_many(board, seeds[:1], **options)  # compiles what is not compiled yet
    with _progress(drops) as progress:
        start = time.perf_counter()
        many = drop_many(board, seeds, progress=progress, **options)
        return many, time.perf_counter() - start


def _progress(drops: int) -> AbstractContextManager[Callable[[int], None] | None]:
    """A progress bar on a terminal, nothing elsewhere."""
    if not common.stderr_is_terminal():
        return nullcontext()
    return _Bar(drops)


class _Bar:
    """A bar on stderr, told how many drops are done in all."""

    def __init__(self, drops: int) -> None:
        import sys

        self._bar = click.progressbar(length=drops, label="drops", file=sys.stderr)

    def __enter__(self) -> Callable[[int], None]:
        self._bar.__enter__()
        return lambda done: self._bar.update(done - self._bar.pos)

    def __exit__(self, *exception: object) -> None:
        self._bar.render_finish()


def _summarise(many: "DropBatch", seconds: float) -> dict[str, Any]:
    """The fields of `--json`. Means are over all drops, unsettled ones included."""
    drops = len(many)
    return {
        "board_digest": many.board.digest,
        "drops": drops,
        "histogram": many.histogram.tolist(),
        "unsettled": many.unsettled,
        # fsum is exact, so the mean has the same bits on every machine.
        "mean_duration": math.fsum(many.duration) / drops,
        "mean_impacts": int(many.impact_count.sum()) / drops,
        "seconds": seconds,
        "drops_per_second": drops / seconds,
        "digest": many.digest,
    }


def _print(many: "DropBatch", first: int, summary: dict[str, Any]) -> None:
    drops, histogram = len(many), summary["histogram"]
    pays = many.board.bins.multipliers
    longest = max(histogram) or 1
    click.echo("bin      pays       drops    share")
    for number, (count, pay) in enumerate(zip(histogram, pays, strict=True)):
        bar = "#" * round(BAR_WIDTH * count / longest)
        click.echo(f"{number:3} {pay:9g} {count:11} {count / drops:8.3%}  {bar}".rstrip())
    click.echo()
    common.print_fields(
        {
            "board": many.board.name,
            "seeds": f"{first} to {first + drops - 1}",
            "solver": common.describe_solver(many.solver),
            "unsettled": str(summary["unsettled"]),
            "return": f"{math.fsum(many.scores) / drops:.3%}",
            "mean drop": f"{summary['mean_duration']:.4f} s, {summary['mean_impacts']:.2f} impacts",
            "speed": f"{summary['drops_per_second']:,.0f} drops/s, {summary['seconds']:.3f} s",
            "digest": summary["digest"],
        }
    )
