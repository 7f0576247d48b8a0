"""`python -m benchmarks.scale`: the tables that docs/scale.md derives, from those recorded."""

from pathlib import Path

import click

from benchmarks.harness.markers import put
from benchmarks.scale.derived import NAME, PAGE, derived


@click.command()
@click.option(
    "--page",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    default=PAGE,
    help="Where they go, between its markers.",
)
def main(page: Path) -> None:
    """Multiply the unit costs that the pages record by what is asked for."""
    put(page, NAME, derived())


if __name__ == "__main__":
    main()
