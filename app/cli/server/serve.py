"""`plinko serve`: run the game server, with a flag for each setting."""

import gc
from collections.abc import Mapping

import click

from app.cli import common
from app.settings import Option, Settings, options


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
    """Read the settings of the environment and these flags; raises SettingError if invalid."""
    given = dict(flags)
    for row in options():
        if isinstance(row.default, tuple) and isinstance(text := given.get(row.name), str):
            given[row.name] = tuple(filter(None, map(str.strip, text.split(","))))
    return Settings.load(overrides=given)


@click.command(
    name="serve",
    short_help="Run the game server.",
    epilog="The environment can set each flag too: PLINKO_PORT sets --port. A flag wins.",
    params=settings_options(),
)
def command(**flags: object) -> None:
    """Run the game server and print its address; Ctrl-C stops it."""
    common.need_server()
    settings = settings_from(flags)

    with common.garbage_waits():
        from app.main import run
    gc.freeze()  # imported objects never become garbage: the collector need not visit them

    run(settings)
