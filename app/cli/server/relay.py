"""`plinko relay`: pass on what happens in rooms to more spectators than one process can serve."""

from typing import Final

import click

from app.cli import common
from app.cli.server.serve import settings_from, settings_options

SETTINGS: Final = (
    "host",
    "port",
    "hosts",
    "allowed_origins",
    "trusted_proxies",
    "max_clients",
    "log_format",
    "log_level",
)
"""Those of the server that a relay has too."""


@click.command(
    name="relay",
    short_help="Serve more spectators of rooms.",
    params=[
        click.Argument(["redis"]),
        click.Argument(["rooms"]),
        *(each for each in settings_options() if each.name in SETTINGS),
    ],
)
def command(redis: str, rooms: str, **flags: object) -> None:
    """Serve spectators of the rooms of the server at ROOMS (http://HOST:8000), by seeds.

    That server and this relay know the same REDIS (redis://HOST:6379): start the server with
    `--relays REDIS`, as many relays as needed, and spread `/ws/rooms/{id}?stream=seeds` over them.
    Who does more than watch gets a line of their own to the server. Ctrl-C stops the relay.
    """
    common.need_server()
    settings = settings_from(flags)
    with common.garbage_waits():
        from app.relay.run import run
    run(settings, redis, rooms)
