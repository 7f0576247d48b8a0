"""`plinko calibrate`: search for the physics that makes a triangle's bins nearly binomial."""

import sys
from typing import TYPE_CHECKING

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.engine.drops.calibrate import Fit


@click.command(name="calibrate", short_help="Search for a triangle's physics.")
@click.option("--rows", type=click.IntRange(8, 16), required=True, help="The triangle's rows.")
@click.option("--trials", type=common.COUNT, default=200, help="Points in the first round.")
@click.option(
    "--drops", type=common.COUNT, default=10_000, help="Drops per point in the first round."
)
@click.option("--check", type=common.COUNT, help="Finally measure with this many new seeds.")
@click.option("--preset", is_flag=True, help="Do not search; measure the preset.")
@common.cluster_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object per line.")
def command(
    rows: int,
    trials: int,
    drops: int,
    check: int | None,
    preset: bool,
    cluster: str | None,
    as_json: bool,
) -> None:
    """Find drag, restitution, friction and jitter that bring a triangle's bins near the binomial.

    The search tries --trials points with --drops drops each. In further rounds it tries a quarter
    as many points, closer to the best one, with twice the drops. It prints each point that is
    better than those before it in its round. `distance` is the total variation distance to the
    binomial; `floor` is the distance that as many fair draws would have. --check measures the last
    point (with --preset the preset) by seeds that the search has not used.
    """
    from plinko.engine.batches.search import search
    from plinko.engine.board import presets
    from plinko.engine.drops import calibrate

    tuning = presets.TUNING[f"triangle-{rows}"]
    if not preset:
        with common.workers(cluster, None) as workers:
            for found in search(rows, trials, drops, workers):
                _show("better", found, as_json)
                tuning = found.tuning
    if preset or check:
        unseen = calibrate.UNSEEN
        _show("check", calibrate.fit(rows, tuning, check or drops, unseen), as_json)


def _show(what: str, found: "Fit", as_json: bool) -> None:
    if as_json:
        common.print_json({"what": what} | _fields(found))
    else:
        parts = [f"{name} {value:.5g}" for name, value in _fields(found).items()]
        common.echo(f"{what}: {', '.join(parts)}")
    sys.stdout.flush()  # a pipe is buffered, and the search takes minutes


def _fields(found: "Fit") -> dict[str, object]:
    return found.tuning._asdict() | {
        "drops": found.drops,
        "distance": found.distance,
        "floor": found.floor,
        "mean_duration": found.duration,
        "mean_impacts": found.impacts,
        "unsettled": found.unsettled_count,
    }
