"""`plinko site`: write the game as static files, which play without a server."""

from pathlib import Path

import click

from plinko.app.cli import common


@click.command(name="site", short_help="Write the game as static files.")
@click.argument("folder", metavar="DIR", type=click.Path(file_okay=False, path_type=Path))
def command(folder: Path) -> None:
    """Write the game into DIR, for any web host: the page computes every drop itself.

    DIR is new or empty, or has an earlier site, which is replaced.
    """
    common.need_server()
    with common.garbage_waits():
        from plinko.app.settings import static_directory
        from plinko.app.web.site import releases_in, write_site
    if folder.is_dir() and any(folder.iterdir()) and not releases_in(folder):
        raise click.UsageError(f"{folder} has other files: give a new folder, or one with a site")
    write_site(static_directory(), folder)
    common.echo(folder / "index.html")
