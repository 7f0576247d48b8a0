"""`plinko integrity`: print the digests of the installed program and of its configuration."""

from pathlib import Path

import click

from plinko.app.cli import common
from plinko.app.cli.server.serve import settings_from, settings_options
from plinko.engine import json_text


@click.command(
    name="integrity",
    short_help="Print digests of code, kernels and configuration.",
    epilog="Give the flags and environment of `plinko serve`: they are the configuration.",
    params=[
        *settings_options(),
        click.Option(["--files", "with_files"], is_flag=True, help="List each file's digest."),
        click.Option(["--json", "as_json"], is_flag=True, help="Print one JSON object."),
        click.Option(
            ["--compare", "other"],
            metavar="LIST",
            type=click.Path(exists=True, dir_okay=False, path_type=Path),
            help="Compare with the output of --files on another machine.",
        ),
    ],
)
def command(with_files: bool, as_json: bool, other: Path | None, **flags: object) -> int:
    """Print the digests that a server with these files and settings reports.

    A server reports them as `GET /api/v1/integrity`; this command needs no server. --files prints
    lines like `sha256sum`. --compare names the first file that differs from such a LIST; the exit
    code is then 1.
    """
    from plinko.app.conformance import inventory

    files = inventory.files_of(inventory.installed())
    if other is not None:
        return _compare(files, other)
    configuration = inventory.configuration_of(settings_from(flags))
    found = inventory.digests_of(files, configuration)
    if as_json:
        common.print_json({**found.to_dict(), "settings": configuration, "files": files})
    elif with_files:
        common.echo(inventory.listed(files), nl=False)
    else:
        common.print_fields(found.to_dict())
    return 0


def _compare(files: dict[str, str], other: Path) -> int:
    from plinko.app.conformance import inventory

    differs = inventory.first_difference(files, inventory.from_list(json_text.read_text(other)))
    common.echo(f"all {len(files)} files agree with {other}" if differs is None else differs)
    return 0 if differs is None else 1
