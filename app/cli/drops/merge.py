"""`plinko merge`: results of some blocks of a batch, put together."""

from pathlib import Path

import click

from app.cli import common


@click.command(name="merge", short_help="Put results of parts of a batch together.")
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option(
    "--out", type=click.Path(dir_okay=False, path_type=Path), help="Keep the result in this file."
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(files: tuple[Path, ...], out: Path | None, as_json: bool) -> None:
    """Put results in FILES together, as `plinko simulate --json` or --resume leaves them.

    They must be of one job, the same board, solver, seeds and aim, and no block may be in two of
    them. With all blocks there the digest is the batch's.
    """
    from app.batches.saved import form_of, load, save
    from app.cli.drops.simulate import print_tally
    from engine import EngineError

    tally, seconds = load(files[0])
    for path in files[1:]:
        other, more = load(path)
        try:
            tally.merge(other)
        except EngineError as error:
            raise click.UsageError(f"{files[0]} and {path}: {error}") from None
        seconds += more
    if out is not None:
        save(out, tally, seconds)
    if as_json:
        common.print_json(form_of(tally, seconds))
    elif tally.drops:
        print_tally(tally, seconds)
