"""`plinko bench`: error, speed, stability, the price of each feature, the literature's figures."""

import importlib.util
import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.cli import common

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.harness.report import Section

WHAT = (
    "accuracy",
    "certified",
    "throughput",
    "lanes",
    "stability",
    "batches",
    "features",
    "stream",
    "page",
    "stranger",
    "render",
    "stepped",
    "relays",
    "literature",
    "scale",
    "attack",
    "silence",
)


@click.command(name="bench", short_help="Measure speed, accuracy and stability.")
@click.argument("what", type=click.Choice([*WHAT, "all"]))
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--quick", is_flag=True, help="Tiny sizes: shows that all works, measures little.")
@click.option(
    "--plots",
    type=click.Path(file_okay=False, path_type=Path),
    help="Draw the figures into this directory.",
)
@click.option(
    "--page",
    "pages",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    multiple=True,
    help="Put the results into this page, between its markers; with --plots. May be repeated.",
)
@click.option(
    "--readme",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Put a short table and a plot of the first page into this file, between its markers.",
)
@click.option(
    "--rounds",
    type=click.IntRange(min=1),
    help="Repeats of each timed job.  [7; with --quick 1]",
)
@click.option("--long", is_flag=True, help="stability: 10^7 random drops; takes hours.")
@click.option(
    "--findings",
    type=click.Path(file_okay=False, path_type=Path),
    help="stability: save the drops that went wrong in this directory.",
)
@common.cluster_option
@click.option("--node/--no-node", default=True, show_default=True, help="Engines for Node.js too.")
def command(
    what: str,
    as_json: bool,
    quick: bool,
    plots: Path | None,
    pages: tuple[Path, ...],
    readme: Path | None,
    rounds: int | None,
    long: bool,
    findings: Path | None,
    cluster: str | None,
    node: bool,
) -> None:
    """Measure the engine, in turns with others where there are others.

    Every table says how it was obtained; times are medians with their spread. The benchmarks are in
    the source repository alone. The peers and the oracle of `accuracy` and all plots need the
    `bench` extra.
    """
    if importlib.util.find_spec("benchmarks") is None:
        raise click.UsageError(
            "the benchmarks are no part of the installed package: run `make bench` in a clone of "
            "the source repository"
        )
    from benchmarks import suite
    from benchmarks.accuracy import readme_table
    from benchmarks.harness import machine
    from benchmarks.harness.effort import Effort, MissingError
    from benchmarks.harness.markers import fill_each

    if pages and not plots:
        raise click.UsageError("--page shows the plots too: say with --plots where they are drawn")
    if readme and not pages:
        raise click.UsageError("--readme takes its table from a page: say which with --page")
    names = WHAT if what == "all" else (what,)
    found = []
    with _progress() as step:
        effort = Effort(
            quick=quick,
            rounds=rounds or (1 if quick else 7),
            long=long,
            node=node,
            findings=findings,
            cluster=cluster,
            step=step,
        )
        about = machine.describe()
        for name in names:
            step(name)
            try:
                found.append(suite.run(name, effort))
            except MissingError as error:
                raise click.UsageError(f"{name}: {error}") from error
    drawn = suite.draw(found, plots) if plots else []
    if pages and plots:
        fill_each(pages, about, found, plots)
        if readme:
            readme_table.renew(readme, pages[0])
    if as_json:
        common.print_json(_as_json(about, quick, found))
    else:
        _print(about, found, drawn)


def _as_json(about: dict[str, str], quick: bool, found: "list[Section]") -> dict[str, object]:
    return {
        "machine": about,
        "quick": quick,
        "sections": {section.name: section.to_dict() for section in found},
    }


def _print(about: dict[str, str], found: "list[Section]", drawn: list[Path]) -> None:
    common.print_fields(about)
    for section in found:
        click.echo(f"\n{section.text()}")
    for path in drawn:
        click.echo(f"\ndrawn: {path}")


def _progress() -> "AbstractContextManager[Callable[[str], None]]":
    """What is being measured, in one line that renews itself; nothing where nobody watches."""
    if not sys.stderr.isatty():
        return nullcontext(lambda label: None)
    return _Spinner()


class _Spinner:
    """A line on stderr with the label of the last piece of work and how many were done."""

    def __init__(self) -> None:
        self._done = 0

    def __enter__(self) -> "Callable[[str], None]":
        return self._show

    def _show(self, label: str) -> None:
        self._done += 1
        dots = "·" * (self._done % 30)
        sys.stderr.write(f"\r\x1b[K{label:<24} {self._done:4} {dots}")
        sys.stderr.flush()

    def __exit__(self, *exception: object) -> None:
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()
