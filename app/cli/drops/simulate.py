"""`plinko simulate`: many seeded drops and what came of them."""

import math
import re
from contextlib import AbstractContextManager, nullcontext
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from app.cli import common

if TYPE_CHECKING:
    from app.batches.running import Run
    from engine.batches.job import Job
    from engine.batches.tally import Tally
    from engine.batches.workers import Workers
    from engine.certified.many import Share

BAR_WIDTH = 40  # characters of the longest bar of the printed histogram

EXIT_INTERRUPTED: Final = 130  # 128 + SIGINT, as a shell reports it


def _count(ctx: click.Context, param: click.Parameter, value: str) -> int:
    """A whole number from 1 on, also as 1e9."""
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
    """`17`, or `0:100` for those up to 99."""
    if value is None:
        return None
    found = re.fullmatch(r"(\d{1,18})(?::(\d{1,18}))?", value)
    if found is None:
        raise click.BadParameter(
            f"{value!r} is neither a block such as 17 nor some such as 0:100", ctx=ctx, param=param
        )
    begin = int(found[1])
    end = begin + 1 if found[2] is None else int(found[2])
    if begin >= end:
        raise click.BadParameter(f"{value!r} has no blocks", ctx=ctx, param=param)
    return begin, end


@click.command(name="simulate", short_help="Drop many balls and count where they land.")
@common.board_argument
@click.option("--drops", required=True, callback=_count, metavar="N", help="How many, as 1e9.")
@click.option("--seed", default="0", show_default=True, help="Of the first; then one more each.")
@common.aim_option
@common.solver_options
@common.workers_options
@click.option(
    "--blocks", callback=_run_of_blocks, metavar="K[:END]", help="Only these blocks of 65,536."
)
@click.option(
    "--resume",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Keep the result in this file as it grows, and go on with what is there.",
)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="A row for each drop: .parquet or .csv.",
)
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
    cluster: str | None,
    blocks: tuple[int, int] | None,
    resume: Path | None,
    out: Path | None,
    certify: bool,
    as_json: bool,
) -> int:
    """Drop many balls on BOARD, seeds FIRST to FIRST + N - 1, and count where they land.

    The digest is over all outcomes in the order of the seeds: the same however the work was split.
    It is the root over blocks of 65,536 drops; one block alone has the hash that it has in the
    whole, and `plinko merge` puts results of some blocks together. An interrupt leaves the result
    of the blocks that were done, and --resume FILE goes on with the others.

    The time is that of the drops alone, without start-up and compilation. With --certify each drop
    is also asked whether its bin is certain; those that are not are proven (milliseconds each).
    """
    how = common.read_solver(solver, dt, substeps, correction)
    if certify:
        _check_certify(solver, aim, {"--blocks": blocks, "--resume": resume, "--out": out})
    from app.batches.running import Run
    from engine.batches.job import Job
    from engine.batches.tally import Tally
    from engine.parameters import make_solver

    found = common.load_board(board)
    job = Job(found, make_solver(how.pop("solver"), **how), common.read_seed(seed), drops, aim)
    begin, end = blocks or (0, job.blocks)
    if end > job.blocks:
        raise click.UsageError(f"--blocks {begin}:{end}: there are {job.blocks}, from 0 on")
    run = Run(Tally(job), path=resume)
    if resume is not None and resume.exists():
        _go_on(run, resume, out)
    with common.workers(cluster, threads) as workers:
        _compute(run, workers, (begin, end), out)
        share = _certified(job, workers) if certify and not run.interrupted else None
    if not run.tally.drops:
        return EXIT_INTERRUPTED
    if as_json:
        from app.batches.saved import form_of

        certified = {"certified": share.to_dict()} if share else {}
        common.print_json(form_of(run.tally, run.seconds) | certified)
    else:
        print_tally(run.tally, run.seconds, share)
    return EXIT_INTERRUPTED if run.interrupted else 0


def _check_certify(solver: str, aim: float | None, others: dict[str, object]) -> None:
    if solver != "exact":
        raise click.UsageError("--certify belongs to --solver exact: a step has its own error")
    if aim is not None:
        raise click.UsageError(f"--certify proves drops that are not aimed, not --aim {aim:g}")
    for name, value in others.items():
        if value is not None:
            raise click.UsageError(f"--certify proves all drops of a run, without {name}")
    common.need_certifier()


def _go_on(run: "Run", path: Path, out: Path | None) -> None:
    """Begin with what the file has."""
    from app.batches.saved import load

    if out is not None:
        raise click.UsageError(
            f"--out {out}: the rows of the blocks in {path} are gone; write rows of the others "
            "by --blocks"
        )
    found, run.seconds = load(path)
    run.tally.merge(found)


def _compute(run: "Run", workers: "Workers", blocks: tuple[int, int], out: Path | None) -> None:
    """Compute the blocks that are not there yet."""
    from app.batches.rows import RowWriter
    from engine import drop_many
    from engine.batches.workers import Here

    job = run.tally.job
    if isinstance(workers, Here):
        # The first drop compiles what is not compiled yet; it is not timed.
        drop_many(job.board, range(job.first, job.first + 1), threads=1, **job.options)
    wanted = job.seeds(blocks[1] - 1).stop - job.seeds(blocks[0]).start
    rows: AbstractContextManager[RowWriter | None] = RowWriter(out) if out else nullcontext()
    done = run.tally.drops
    with rows as writer, common.progress(max(wanted, done), "drops", done) as told:
        run.compute(workers, run.tally.missing(*blocks), told, writer)


def _certified(job: "Job", workers: "Workers") -> "Share":
    """How many of the bins are right; those that are not certain are proven."""
    from engine.batches.certify import certify_all

    with common.progress(job.drops, "proofs") as told:
        return certify_all(job, workers, told)


def print_tally(tally: "Tally", seconds: float, share: "Share | None" = None) -> None:
    """Histogram and sums, for people."""
    job, summary = tally.job, tally.summary()
    pays = job.board.bins.multipliers
    drops, histogram = tally.drops, summary["histogram"]
    longest = max(histogram) or 1
    click.echo("bin      pays       drops    share")
    for number, (count, pay) in enumerate(zip(histogram, pays, strict=True)):
        bar = "#" * round(BAR_WIDTH * count / longest)
        click.echo(f"{number:3} {pay:9g} {count:11} {count / drops:8.3%}  {bar}".rstrip())
    # An unsettled drop gives its stake back.
    paid = math.fsum(n * pay for n, pay in zip(histogram, pays, strict=True)) + summary["unsettled"]
    speed = {"speed": f"{drops / seconds:,.0f} drops/s, {seconds:.3f} s"} if seconds else {}
    click.echo()
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
    """The batch's digest, or what the result covers and, of one block, its hash."""
    if tally.digest is not None:
        return {"digest": tally.digest}
    runs = ", ".join(f"{a}" if a + 1 == b else f"{a} to {b - 1}" for a, b in tally.blocks)
    covers = f"{tally.drops:,} of {tally.job.drops:,} drops: blocks {runs} of {tally.job.blocks}"
    (first, end), *more = tally.blocks
    only = tally.hash_of(first) if not more and first + 1 == end else None
    return {"covers": covers, **({} if only is None else {"hash": only.hex()})}


def _how_right(share: "Share") -> dict[str, str]:
    """What the proofs say of double precision."""
    undecided = f", {share.undecided} undecided" if share.undecided else ""
    return {
        "certain": f"{share.certain} of {share.drops} bins, by estimate",
        "proven": f"the other {share.proven}: {share.right} right, {share.wrong} wrong{undecided}",
        "right": f"{share.share_right:.2%} of the bins in double precision",
    }
