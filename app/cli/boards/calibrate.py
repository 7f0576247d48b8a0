"""`plinko calibrate`: search for the physics that makes a triangle's walk binomial."""

import sys
from typing import TYPE_CHECKING

import click

from app.cli import common

if TYPE_CHECKING:
    from engine.drops.calibrate import Fit


@click.command(name="calibrate", short_help="Search for a triangle's physics.")
@click.option("--rows", type=click.IntRange(8, 16), required=True, help="Of the triangle.")
@click.option("--trials", type=click.IntRange(min=1), default=200, show_default=True)
@click.option("--drops", type=click.IntRange(min=1), default=10_000, show_default=True)
@click.option("--check", type=click.IntRange(min=1), help="Drops of a last look with new seeds.")
@click.option("--preset", is_flag=True, help="Search nothing: look at the preset as it is.")
@common.cluster_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object a line.")
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

    A sweep of --trials points with --drops drops each, then rounds of a quarter as many points
    nearer and nearer the best, with twice the drops each time. Each line is better than the one
    before it in its round. The distance is the total variation; the floor beside it is what as
    many fair draws would show. --check measures the last, or with --preset the preset, with seeds
    that no search has seen.
    """
    from engine.batches.search import search
    from engine.board import presets
    from engine.drops import calibrate

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
        click.echo(f"{what}: {', '.join(parts)}")
    sys.stdout.flush()  # a search takes minutes; whoever reads a pipe wants to see it


def _fields(found: "Fit") -> dict[str, object]:
    return found.tuning._asdict() | {
        "drops": found.drops,
        "distance": found.distance,
        "floor": found.floor,
        "mean_duration": found.duration,
        "mean_impacts": found.impacts,
        "unsettled": found.unsettled,
    }
