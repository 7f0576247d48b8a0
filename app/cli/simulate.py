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

    from engine import Board
    from engine.certified.many import Share
    from engine.drops.tally import Tally

CHUNK = 1 << 18  # drops held at once: some 10 MB, and enough work for every core
BAR_WIDTH = 40  # characters of the longest bar of the printed histogram


@click.command(name="simulate", short_help="Drop many balls and count where they land.")
@common.board_argument
@click.option("--drops", type=click.IntRange(min=1), required=True, help="How many.")
@click.option("--seed", default="0", show_default=True, help="Of the first; then one more each.")
@common.aim_option
@common.solver_options
@click.option("--threads", type=click.IntRange(min=1), help="Default: every core.")
@click.option("--certify", is_flag=True, help="Prove each bin that rounding may decide.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    drops: int,
    seed: str,
    aim: float | None,
    solver: str,
    dt: float | None,
    substeps: int | None,
    correction: float | None,
    threads: int | None,
    certify: bool,
    as_json: bool,
) -> None:
    """Drop many balls on BOARD, seeds FIRST to FIRST + N - 1, and count where they land.

    The digest is over all outcomes in the order of the seeds: the same however the work was split.
    The time is that of the drops alone, without start-up and compilation. With --certify each drop
    is also asked whether its bin is certain; those that are not are proven (milliseconds each).
    """
    how = common.read_solver(solver, dt, substeps, correction)
    first = common.read_seed(seed)
    common.read_seed(str(first + drops - 1))
    if certify:
        if solver != "exact":
            raise click.UsageError("--certify belongs to --solver exact: a step has its own error")
        if aim is not None:
            raise click.UsageError(f"--certify proves drops that are not aimed, not --aim {aim:g}")
        common.need_certifier()
    tally, summary = _run(
        common.load_board(board), first, drops, how | {"threads": threads, "aim": aim}
    )
    share = _certified(tally.board, first, drops) if certify else None
    if as_json:
        common.print_json(summary | ({"certified": share.to_json()} if share else {}))
    else:
        _print(tally, summary, first, share)


def _certified(board: "Board", first: int, drops: int) -> "Share":
    """How many of the bins are right; those that are not certain are proven."""
    from engine.certified.many import certify_many

    with _progress(drops, "proofs") as bar:
        return certify_many(board, range(first, first + drops), progress=_after(0, bar))


def _run(
    board: "Board", first: int, drops: int, options: dict[str, Any]
) -> "tuple[Tally, dict[str, Any]]":
    """The tally, and the fields of `--json`."""
    from engine import drop_many
    from engine.drops.tally import Tally

    # The first drop compiles what is not compiled yet; it is not timed.
    tally = Tally(board, drop_many(board, range(first, first + 1), **options).solver)
    seconds = 0.0
    with _progress(drops) as bar:
        while tally.drops < drops:
            done = tally.drops
            seeds = range(first + done, first + min(done + CHUNK, drops))
            start = time.perf_counter()
            batch = drop_many(board, seeds, progress=_after(done, bar), **options)
            seconds += time.perf_counter() - start
            tally.add(batch)
    summary = tally.summary()
    digest = summary.pop("digest")
    speed = {"seconds": seconds, "drops_per_second": drops / seconds}
    return tally, {**summary, **speed, "digest": digest}


def _after(done: int, bar: "ProgressBar[int] | None") -> Callable[[int], None] | None:
    """A callback for a chunk that starts when `done` drops are done."""
    if bar is None:
        return None
    return lambda more: bar.update(done + more - bar.pos)


def _progress(
    drops: int, label: str = "drops"
) -> "AbstractContextManager[ProgressBar[int] | None]":
    """A progress bar on stderr where somebody sees it, nothing elsewhere."""
    if not sys.stderr.isatty():
        return nullcontext()
    return click.progressbar(length=drops, label=label, file=sys.stderr)


def _print(tally: "Tally", summary: dict[str, Any], first: int, share: "Share | None") -> None:
    pays = tally.board.bins.multipliers
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
            **(_how_right(share) if share else {}),
        }
    )


def _how_right(share: "Share") -> dict[str, str]:
    """What the proofs say of double precision."""
    undecided = f", {share.undecided} undecided" if share.undecided else ""
    return {
        "certain": f"{share.certain} of {share.drops} bins, by estimate",
        "proven": f"the other {share.proven}: {share.right} right, {share.wrong} wrong{undecided}",
        "right": f"{share.share_right:.2%} of the bins in double precision",
    }
