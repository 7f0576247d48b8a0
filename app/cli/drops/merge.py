"""`plinko merge`: combine results of parts of a batch."""

from pathlib import Path

import click

from plinko.app.cli import common


@click.command(name="merge", short_help="Combine results of parts of a batch.")
@click.argument("files", nargs=-1, required=True, type=common.IN)
@click.option("--out", type=common.OUT, help="Also save the result here.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(files: tuple[Path, ...], out: Path | None, as_json: bool) -> None:
    """Combine results in FILES, written by `plinko simulate` with --json or --resume.

    All must have the same board, solver, seeds and aim, and no block may be in two files. If all
    blocks of the batch are there, the result has its digest.
    """
    from plinko.app.batches.saved import form_of, load, save
    from plinko.app.cli.drops.simulate import print_tally
    from plinko.engine import PlinkoError

    tally, seconds = load(files[0])
    for path in files[1:]:
        other, more = load(path)
        try:
            tally.merge(other)
        except PlinkoError as error:
            raise click.UsageError(f"{files[0]} and {path}: {error}") from None
        seconds += more
    if out is not None:
        save(out, tally, seconds)
    if as_json:
        common.print_json(form_of(tally, seconds))
    elif tally.drops:
        print_tally(tally, seconds)
