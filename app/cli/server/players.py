"""`plinko players`: erase a player of a running server, or ban one for a time."""

import urllib.parse

import click

from plinko.app.cli import common
from plinko.app.cli.server.halt import ask


@click.group(name="players", short_help="Erase or ban a server's players.")
def command() -> None:
    """Erase or ban players of a running server.

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


@command.command(name="ban")
@click.argument("client")
@click.argument("url", default="http://127.0.0.1:8000")
@click.option("--minutes", default=60, show_default=True, help="For how long; 0 ends the ban.")
def ban(client: str, url: str, minutes: int) -> None:
    """Ban CLIENT for a time: an address from everything, or a player's mark from drops."""
    found = ask(url, "/api/v1/bans", {"client": client, "minutes": minutes})
    common.print_fields({"banned": found["client"], "minutes": found["minutes"]})
