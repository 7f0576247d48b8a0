"""`plinko halt`: have a running server's tables take no drops, or let them go on."""

import click

from app.cli import common
from app.cli.operator import ask


@click.command(name="halt", short_help="Halt a server's tables, or let them go on.")
@click.argument("url")
@click.option("--room", help="Which table; without it, all of them.")
@click.option("--release", is_flag=True, help="Let it go on.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(url: str, room: str | None, release: bool, as_json: bool) -> None:
    """Halt the tables of the server at URL: no new drops; balls in flight land and are paid.

    PLINKO_OPERATOR_TOKEN in the environment is what the server was started with. A halt outlives
    the server; --release ends it.
    """
    found = ask(url, "/api/v1/halts", {"room": room, "halted": not release})
    if as_json:
        common.print_json(found)
        return
    rooms = ", ".join(each["room"] for each in found["rooms"])
    common.print_fields(
        {"all tables": "halted" if found["all_since"] else "go on", "halted by themselves": rooms}
    )
