"""`python -m benchmarks`: one command for each question, `all`, `pages` and `load`."""

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from benchmarks import suite
from benchmarks.harness import machine, pages, recorded
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section
from benchmarks.load.command import load
from benchmarks.scale import estimates


class _Grouped(click.Group):
    """A command group whose help lists the benchmarks by subject."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each benchmark's name and question."""
        others = [name for name in self.commands if name not in suite.BENCHMARKS]
        for title, names in {**suite.GROUPS, "More": dict.fromkeys(others)}.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(name, self.commands[name].get_short_help_str(100)) for name in names]
                )


@click.group(cls=_Grouped, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Measure the engine and the server, in turns with other engines where they exist.

    Each command prints tables and says how it measured them; times are medians with their spread.
    --record writes the tables to docs/measured, which the site shows, and updates the README. The
    other engines, the oracle and the plots need the `bench` group: `make bench` installs it and
    records every benchmark.
    """


def _measuring(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that every benchmark has."""
    for option in (
        click.option("--record", is_flag=True, help="Write docs/measured and update the README."),
        click.option(
            "--rounds", type=click.IntRange(min=1), help="Runs of each timed job. [3; quick: 1]"
        ),
        click.option("--quick", is_flag=True, help="Use tiny sizes, only to show that it works."),
    ):
        command = option(command)
    return command


def _add(name: str, question: str) -> None:
    @_measuring
    @click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
    def command(quick: bool, rounds: int | None, record: bool, as_json: bool, **more: Any) -> None:
        about = machine.describe()
        try:
            section, seconds = _measured(name, _effort(quick, rounds, record, **more))
            if record:
                recorded.write(section, about, seconds, recorded.FOLDER)
                _fill()
        except MissingError as error:
            raise click.ClickException(f"{name}: {error}") from error
        if as_json:
            click.echo(json.dumps({"machine": about, "quick": quick, **section.to_dict()}))
        else:
            click.echo("\n".join(f"{key}  {value}" for key, value in about.items()))
            click.echo(f"\n{section.text()}")

    for option in _MORE.get(name, ()):
        command = option(command)
    main.command(name, help=question)(command)


_MORE: dict[str, tuple[Any, ...]] = {
    "accuracy": (
        click.option("--node/--no-node", default=True, help="Include Node.js engines. [yes]"),
    ),
    "stability": (
        click.option("--long", is_flag=True, help="Play 10^7 random drops, which takes hours."),
        click.option(
            "--findings", type=click.Path(file_okay=False, path_type=Path),
            help="Save faulty drops in this directory.",
        ),
        click.option("--cluster", metavar="WHERE", help="As in `plinko simulate`."),
    ),
}  # fmt: skip
"""Extra options, by the benchmark that has them."""


def _effort(quick: bool, rounds: int | None, record: bool, **more: Any) -> Effort:
    """Raises UsageError for a quick run with --record."""
    if quick and record:
        raise click.UsageError("a quick run is too small to measure anything: it is not recorded")
    return Effort(quick=quick, rounds=rounds or (1 if quick else 3), **more)


def _measured(name: str, effort: Effort) -> tuple[Section, float]:
    """Run a benchmark; returns its section and the seconds that it took."""
    began = time.monotonic()
    with _progress() as step:
        section = suite.run(name, effort.telling(step))
    return section, time.monotonic() - began


@main.command("all")
@_measuring
def every(quick: bool, rounds: int | None, record: bool) -> None:
    """Run all benchmarks, one after the other.

    With --record, each is recorded as soon as it ends. A benchmark that cannot run on this machine
    is named at the end.
    """
    effort, missing = _effort(quick, rounds, record), {}
    for name in suite.BENCHMARKS:
        about = machine.describe()
        try:
            section, seconds = _measured(name, effort)
        except MissingError as error:
            missing[name] = str(error)
            continue
        if record:
            recorded.write(section, about, seconds, recorded.FOLDER)
        click.echo(f"\n{section.text()}\n\n{name}: {seconds:,.0f} s")
    if record:
        _fill()
    for name, why in missing.items():
        click.echo(f"not measured: {name}: {why}", err=True)
    if missing:
        raise SystemExit(1)


@main.command("pages")
def fill() -> None:
    """Renew the estimates in docs/measured and the table in the README."""
    try:
        _fill()
    except MissingError as error:
        raise click.ClickException(str(error)) from error


def _fill() -> None:
    estimates.FILE.write_text(estimates.record(), encoding="utf-8")
    text = pages.README.read_text(encoding="utf-8")
    pages.README.write_text(pages.filled(text, pages.README.parent), encoding="utf-8")


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Show the label of the latest step in one line, if stderr is a terminal."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return

    def show(label: str) -> None:
        sys.stderr.write(f"\r\x1b[K{label}")
        sys.stderr.flush()

    yield show
    show("")


for _name, _benchmark in suite.BENCHMARKS.items():
    _add(_name, _benchmark.question)
main.add_command(load)

if __name__ == "__main__":
    main(prog_name="python -m benchmarks")
