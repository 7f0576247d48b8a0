"""`plinko rooms`: move rooms between the servers of a cluster."""

import urllib.parse

import click

from plinko.app.cli import common
from plinko.app.cli.server.halt import ask


@click.group(name="rooms", short_help="Move rooms between the servers of a cluster.")
def command() -> None:
    """Move rooms between the servers of a cluster."""


@command.command(name="move", short_help="Give a room to another server.")
@click.argument("room")
@click.argument("name")
@click.argument("url", default="http://127.0.0.1:8000")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def move(room: str, name: str, url: str, as_json: bool) -> None:
    """Move ROOM to the server called NAME, which continues it at the same tick.

    URL is any server of the cluster, or the proxy in front of them. PLINKO_OPERATOR_TOKEN in the
    environment must be the token that they were started with.
    """
    path = f"/api/v1/rooms/{urllib.parse.quote(room, safe='')}/move"
    found = ask(url, path, {"to": name})
    if as_json:
        common.print_json(found)
    else:
        common.print_fields({"room": found["room"], "server": found["server"]})
