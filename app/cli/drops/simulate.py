"""`plinko simulate`: drop many seeds and count where the balls land."""

import math
import re
from contextlib import AbstractContextManager, nullcontext
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.app.batches.running import Run
    from plinko.engine.batches.job import Job
    from plinko.engine.batches.tally import Tally
    from plinko.engine.batches.workers import Workers
    from plinko.engine.certified.many import Share

BAR_WIDTH = 40  # characters of the longest bar of the printed histogram

SIGNALLED: Final = 128  # plus the signal is the exit code, as of a shell


def _count(ctx: click.Context, param: click.Parameter, value: str) -> int:
    """Parse a whole number from 1 on, also in the form 1e9."""
    number = 0
    if re.fullmatch(r"\d{1,20}(\.\d{1,20})?(e\d{1,2})?", value):
        exact = Decimal(value)
        number = int(exact) if exact == exact.to_integral_value() else 0
    if number < 1:
        raise click.BadParameter(
            f"{value!r} is not a whole number from 1 on, such as 1000 or 1e9", ctx=ctx, param=param
        )
    return number


def _run_of_blocks(
    ctx: click.Context, param: click.Parameter, value: str | None
) -> tuple[int, int] | None:
    """Parse `17`, or `0:100` for blocks 0 to 99."""
    if value is None:
        return None
    found = re.fullmatch(r"(\d{1,18})(?::(\d{1,18}))?", value)
    if found is None:
        raise click.BadParameter(
            f"{value!r} is neither a block such as 17 nor a range such as 0:100",
            ctx=ctx,
            param=param,
        )
    begin = int(found[1])
    end = begin + 1 if found[2] is None else int(found[2])
    if begin >= end:
        raise click.BadParameter(
            f"{value!r} is an empty range: END must be greater than K", ctx=ctx, param=param
        )
    return begin, end


@click.command(name="simulate", short_help="Drop many balls and count where they land.")
@common.board_argument
@click.option("--drops", required=True, callback=_count, metavar="N", help="How many, such as 1e9.")
@click.option("--seed", default="0", help="The first seed; each next drop adds one.")
@common.aim_option
@common.solver_options
@common.workers_options
@click.option(
    "--blocks",
    callback=_run_of_blocks,
    metavar="K[:END]",
    help="Only these blocks of 65,536 drops.",
)
@click.option(
    "--resume",
    type=common.OUT,
    help="Save the result in this file regularly; if the file exists, continue its run.",
)
@click.option("--out", type=common.OUT, help="Write a row for each drop: .parquet or .csv.")
@click.option("--certify", is_flag=True, help="Prove each bin that rounding may decide.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    drops: int,
    seed: str,
    aim: float | None,
    how: common.Options,
    threads: int | None,
    cluster: str | None,
    blocks: tuple[int, int] | None,
    resume: Path | None,
    out: Path | None,
    certify: bool,
    as_json: bool,
) -> int:
    """Drop N balls on BOARD, with the seeds from --seed on, and count where they land.

    The digest covers all outcomes in the order of the seeds, and does not depend on how the work
    was split. It is the root of a hash tree over blocks of 65,536 drops. --blocks computes some
    blocks only; `plinko merge` combines such results. A run stopped by Ctrl-C or SIGTERM prints the
    result of its finished blocks; --resume FILE continues it.

    The time does not include start-up and compilation. --certify proves each bin that rounding may
    decide (milliseconds each).
    """
    if certify:
        _check_certify(how["solver"], aim, {"--blocks": blocks, "--resume": resume, "--out": out})
    from plinko.app.batches.running import Run
    from plinko.app.batches.stopping import terminable
    from plinko.engine.batches.job import Job
    from plinko.engine.batches.tally import Tally
    from plinko.engine.parameters import make_solver

    found = common.load_board(board)
    job = Job(found, make_solver(how.pop("solver"), **how), common.read_seed(seed), drops, aim)
    begin, end = blocks or (0, job.blocks)
    if end > job.blocks:
        raise click.UsageError(
            f"--blocks {begin}:{end}: this batch has {common.counted(job.blocks, 'block')}, "
            "numbered from 0"
        )
    run = Run(Tally(job), path=resume)
    if resume is not None and resume.exists():
        _go_on(run, resume, out)
    with terminable(), common.workers(cluster, threads) as workers:
        _compute(run, workers, (begin, end), out)
        share = _certified(job, workers) if certify and run.stopped is None else None
    code = 0 if run.stopped is None else SIGNALLED + run.stopped
    if not run.tally.drops:
        return code
    if as_json:
        from plinko.app.batches.saved import form_of

        certified = {"certified": share.to_dict()} if share else {}
        common.print_json(form_of(run.tally, run.seconds) | certified)
    else:
        print_tally(run.tally, run.seconds, share)
    return code


def _check_certify(solver: str, aim: float | None, others: dict[str, object]) -> None:
    if solver != "exact":
        raise click.UsageError("--certify needs --solver exact: fixed time steps add an error")
    if aim is not None:
        raise click.UsageError(f"--certify cannot prove aimed drops: omit --aim {aim:g}")
    for name, value in others.items():
        if value is not None:
            raise click.UsageError(f"--certify proves all drops of a run: omit {name}")
    common.need_certifier()


def _go_on(run: "Run", path: Path, out: Path | None) -> None:
    from plinko.app.batches.saved import load

    if out is not None:
        raise click.UsageError(
            f"--out {out}: {path} keeps no rows of its finished blocks; write the rows of the "
            "other blocks with --blocks and without --resume"
        )
    found, run.seconds = load(path)
    run.tally.merge(found)


def _compute(run: "Run", workers: "Workers", blocks: tuple[int, int], out: Path | None) -> None:
    """Compute the blocks of the range `blocks` that `run` does not have yet."""
    from plinko.app.batches.rows import RowWriter
    from plinko.engine import drop_many
    from plinko.engine.batches.workers import Here

    job = run.tally.job
    if isinstance(workers, Here):
        # The first drop may compile kernels; the measured time must not include this.
        drop_many(job.board, range(job.first, job.first + 1), threads=1, **job.options)
    wanted = job.seeds(blocks[1] - 1).stop - job.seeds(blocks[0]).start
    rows: AbstractContextManager[RowWriter | None] = RowWriter(out) if out else nullcontext()
    done = run.tally.drops
    with rows as writer, common.progress(max(wanted, done), "drops", done) as progress:
        run.compute(workers, run.tally.missing(*blocks), progress, writer)


def _certified(job: "Job", workers: "Workers") -> "Share":
    """Prove the bins that rounding may decide, and count the right ones."""
    from plinko.engine.batches.certify import certify_all

    with common.progress(job.drops, "proofs") as progress:
        return certify_all(job, workers, progress)


def print_tally(tally: "Tally", seconds: float, share: "Share | None" = None) -> None:
    """Print the histogram, the return and the digest as text."""
    job, summary = tally.job, tally.summary()
    pays = job.board.bins.multipliers
    drops, histogram = tally.drops, summary["histogram"]
    longest = max(histogram) or 1
    common.echo("bin      pays       drops    share")
    for number, (count, pay) in enumerate(zip(histogram, pays, strict=True)):
        bar = "#" * round(BAR_WIDTH * count / longest)
        common.echo(f"{number:3} {pay:9g} {count:11} {count / drops:8.3%}  {bar}".rstrip())
    # An unsettled drop gives its stake back.
    paid = math.fsum(n * pay for n, pay in zip(histogram, pays, strict=True)) + summary["unsettled"]
    speed = {"speed": f"{drops / seconds:,.0f} drops/s, {seconds:.3f} s"} if seconds else {}
    common.echo()
    common.print_fields(
        {
            "board": job.board.name,
            "seeds": f"{job.first} to {job.first + job.drops - 1}",
            "solver": common.describe_solver(job.solver),
            "unsettled": str(summary["unsettled"]),
            "return": f"{paid / drops:.3%}",
            "mean drop": f"{summary['mean_duration']:.4f} s, {summary['mean_impacts']:.2f} impacts",
            **speed,
            **_digest(tally),
            **(_how_right(share) if share else {}),
        }
    )


def _digest(tally: "Tally") -> dict[str, str]:
    """The digest of a complete batch, else the range covered; a single block's hash with it."""
    if tally.digest is not None:
        return {"digest": tally.digest}
    runs = ", ".join(f"{a}" if a + 1 == b else f"{a} to {b - 1}" for a, b in tally.blocks)
    covers = f"{tally.drops:,} of {tally.job.drops:,} drops: blocks {runs} of {tally.job.blocks}"
    (first, end), *more = tally.blocks
    only = tally.hash_of(first) if not more and first + 1 == end else None
    return {"covers": covers, **({} if only is None else {"hash": only.hex()})}


def _how_right(share: "Share") -> dict[str, str]:
    undecided = f", {share.undecided} undecided" if share.undecided else ""
    return {
        "certain": f"{share.certain} of {share.drops} bins, by estimate",
        "proven": f"the other {share.proven}: {share.right} right, {share.wrong} wrong{undecided}",
        "right": f"{share.share_right:.2%} of the bins in double precision",
    }
