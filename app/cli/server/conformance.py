"""`plinko conformance`: test the random starts of staked drops, and the symmetry of the physics."""

import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.app.conformance.generator import Report
    from plinko.app.conformance.mirror import Mirror


@click.command(name="conformance", short_help="Test the random starts of staked drops.")
@common.board_argument
@click.option(
    "--drops",
    type=click.IntRange(min=1),
    default=1_000_000,
    show_default=True,
    help="Starts to test, rounded up to a multiple of 64,000.",
)
@click.option(
    "--pairs",
    type=click.IntRange(min=1),
    default=10_000,
    show_default=True,
    help="Drops to compare with their mirror images.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(board: str, drops: int, pairs: int, as_json: bool) -> int:
    """Test the starts of DROPS staked drops on BOARD, drawn like those of fair sessions.

    The tests concern uniformity, independence of consecutive drops and of sessions, and scaling. p
    is the probability that a good generator deviates as much; a good generator passes all tests
    with 99 % probability. Then PAIRS balls fall from x and from -x, and must end alike, bit for
    bit. Exit code 1 if anything fails.
    """
    from plinko.app.conformance.generator import check_generator
    from plinko.app.conformance.mirror import check_mirror

    chosen = common.load_board(board)
    mirror = check_mirror(chosen, pairs)
    progress = click.progressbar(length=drops, label="drops", file=sys.stderr)
    with progress if sys.stderr.isatty() else nullcontext() as bar:
        report = check_generator(
            chosen, drops, progress=lambda done: None if bar is None else bar.update(done)
        )
    good = report.good and not mirror.unlike
    if as_json:
        common.print_json({**report.to_dict(), "mirror": mirror.to_dict(), "good": good})
    else:
        _show(report, mirror)
    return 0 if good else 1


def _show(report: "Report", mirror: "Mirror") -> None:
    failed = report.failed
    for each in report.outcomes:
        common.echo(f"{'FAILED' if each in failed else 'passed'}  p = {each.p:.4f}  {each.name}")
    common.echo(f"{report.outside} of {report.drops:,} starts outside the board's range")
    common.echo(f"{len(failed)} of {len(report.outcomes)} tests fail, together at 99 %")
    common.echo(f"{len(mirror.unlike)} of {mirror.pairs:,} drops end unlike their mirror images")
