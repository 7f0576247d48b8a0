"""`plinko relay`: serve more spectators of a server's rooms than one process can."""

from typing import Final

import click

from plinko.app.cli import common
from plinko.app.cli.server.serve import settings_from, settings_options

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
"""Settings of the server that a relay has too."""


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
    """Serve spectators of the rooms of the server at ROOMS (http://HOST:8000).

    The server and its relays use the same REDIS (redis://HOST:6379). Start the server with
    `--relays REDIS`, start any number of relays, and have a proxy spread
    `/ws/rooms/{id}?stream=seeds` over them. A relay proxies clients that do more than watch to the
    server. Ctrl-C stops the relay.
    """
    common.need_server()
    settings = settings_from(flags)
    with common.garbage_waits():
        from plinko.app.relay.served import run
    run(settings, redis, rooms)
