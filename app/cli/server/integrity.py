"""`plinko integrity`: the digests of the program as installed, as the server tells them."""

from pathlib import Path

import click

from app.cli import common
from app.cli.server.serve import settings_from, settings_options


@click.command(
    name="integrity",
    short_help="Digests of code, kernels and configuration.",
    epilog="Flags and environment as those of `plinko serve`: they are the configuration.",
    params=[
        *settings_options(),
        click.Option(["--files", "with_files"], is_flag=True, help="List each file's digest."),
        click.Option(["--json", "as_json"], is_flag=True, help="Print one JSON object."),
        click.Option(
            ["--compare", "other"],
            metavar="LIST",
            type=click.Path(exists=True, dir_okay=False, path_type=Path),
            help="Compare with what --files printed elsewhere.",
        ),
    ],
)
def command(with_files: bool, as_json: bool, other: Path | None, **flags: object) -> int:
    """Print what `GET /api/v1/integrity` of a server with these files and settings says.

    It needs no server and no network. With --files the lines are those of `sha256sum`; --compare
    names the first file that differs from such a LIST, and then the exit code is 1.
    """
    from app.conformance import inventory

    files = inventory.files_of(inventory.installed())
    if other is not None:
        return _compare(files, other)
    configuration = inventory.configuration_of(settings_from(flags))
    found = inventory.digests_of(files, configuration)
    if as_json:
        common.print_json({**found.to_dict(), "settings": configuration, "files": files})
    elif with_files:
        click.echo(inventory.listed(files), nl=False)
    else:
        common.print_fields(found.to_dict())
    return 0


def _compare(files: dict[str, str], other: Path) -> int:
    from app.conformance import inventory

    differs = inventory.first_difference(files, inventory.from_list(other.read_text("utf-8")))
    click.echo(f"all {len(files)} files are those of {other}" if differs is None else differs)
    return 0 if differs is None else 1
