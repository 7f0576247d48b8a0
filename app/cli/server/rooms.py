"""`plinko rooms`: close a room of a running server, or move it to another server."""

import urllib.parse

import click

from plinko.app.cli import common
from plinko.app.cli.server.halt import ask


@click.group(name="rooms", short_help="Close a room, or move it to another server.")
def command() -> None:
    """Close a room, or move it to another server of a cluster."""


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


@command.command(name="close", short_help="Close a player's room.")
@click.argument("room")
@click.argument("url", default="http://127.0.0.1:8000")
def close(room: str, url: str) -> None:
    """Close ROOM for good: its balls land and are paid, and everyone in it is disconnected.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """
    ask(url, f"/api/v1/rooms/{urllib.parse.quote(room, safe='')}", None, "DELETE")
    common.print_fields({"closed": room})
