"""`plinko serve` and `plinko relay`: run the game server, with a flag for each setting."""

import gc
import logging
import os
from collections.abc import Mapping
from typing import Final

import click

from plinko.app.cli import common
from plinko.app.settings import Option, Settings, options


def _flag(row: Option) -> click.Option:
    # The flag has no default, so that an omitted one leaves the value of the environment.
    kind = type(row.default)
    shown = ",".join(row.default) if kind is tuple else str(row.default)
    return click.Option(
        [row.flag, row.name],
        type=str if kind is tuple else kind,
        metavar={int: "N", float: "X"}.get(kind, "TEXT"),
        help=row.text + (f"  [{shown}]" if shown else ""),
    )


def settings_options() -> list[click.Parameter]:
    return [_flag(row) for row in options() if row.flag]


def settings_from(flags: Mapping[str, object]) -> Settings:
    """Read the settings of the environment and these flags; raises SettingError if invalid.

    If the log is to be JSON, that error will be, too.
    """
    from plinko.app.ops import logs

    given = dict(flags)
    if (given.get("log_format") or os.environ.get("PLINKO_LOG_FORMAT")) == "json":
        logs.configure("warning", "json")
    for row in options():
        if isinstance(row.default, tuple) and isinstance(text := given.get(row.name), str):
            given[row.name] = tuple(filter(None, map(str.strip, text.split(","))))
    return Settings.load(overrides=given)


def restore_if_refused(settings: Settings) -> None:
    """Restore a ledger that the server would refuse; raises SettingError."""
    from plinko.app.cli.server.ledger import lines_of, restore_ledger
    from plinko.app.persistence.ledger.database import Database

    database = Database(settings.ledger_url, beside=settings.epoch_file)
    if database.in_memory or (database.file is not None and not database.file.exists()):
        return
    database.open(check=False, enter=False)
    difference = database.difference()
    database.close()
    if difference is not None:
        for line in lines_of(restore_ledger(settings)):
            logging.getLogger("plinko").warning(line)


@click.command(
    name="serve",
    short_help="Run the game server.",
    epilog="The environment can set each flag too: PLINKO_PORT sets --port. A flag wins.",
    params=settings_options(),
)
@click.option("--check", is_flag=True, help="Only check the settings; exit code 2 if one is wrong.")
@click.option("--restore", is_flag=True, help="Do `plinko ledger restore` first, if it is needed.")
def command(check: bool, restore: bool, **flags: object) -> None:
    """Run the game server and print its address; Ctrl-C stops it."""
    common.need_server()
    settings = settings_from(flags)
    if check:
        from plinko.app.main import check as check_settings

        check_settings(settings)
        common.echo("the settings are valid")
        return
    if restore:
        restore_if_refused(settings)

    with common.garbage_waits():
        from plinko.app.main import run
    gc.freeze()  # imported objects never become garbage: the collector need not visit them

    run(settings)


RELAYS: Final = (
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
        *(each for each in settings_options() if each.name in RELAYS),
    ],
)
def relay(redis: str, rooms: str, **flags: object) -> None:
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
