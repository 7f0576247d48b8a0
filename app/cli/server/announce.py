"""`plinko announce`: show a text to all players of a running server."""

import click

from plinko.app.cli import common
from plinko.app.cli.server.halt import ask


@click.command(name="announce", short_help="Show a text to all players of a server.")
@click.argument("text")
@click.argument("url", default="http://127.0.0.1:8000")
def command(text: str, url: str) -> None:
    """Show TEXT on the pages of all players at the server at URL; an empty text ends it.

    PLINKO_OPERATOR_TOKEN in the environment must be the token that the server was started with.
    """
    found = ask(url, "/api/v1/announcement", {"text": text or None})
    common.print_fields({"announced": found["text"] or "nothing"})
