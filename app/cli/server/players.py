"""`plinko players`: what the operator of a running server does about a player."""

import urllib.parse

import click

from plinko.app.cli import common
from plinko.app.cli.server.halt import ask


@click.group(name="players", short_help="Erase a player's data.")
def command() -> None:
    """Erase a player's data at a running server.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """


@command.command(name="erase")
@click.argument("who")
@click.argument("url", default="http://127.0.0.1:8000")
def erase(who: str, url: str) -> None:
    """Take the mark WHO, and names and colours, from all of a player's drops.

    WHO is what the player's page sends as `who`. Drops, results, sums and receipts stay: they say
    nothing of the player.
    """
    path = f"/api/v1/players/{urllib.parse.quote(who, safe='')}"
    common.print_fields({"rows": ask(url, path, None, "DELETE")["rows"]})
