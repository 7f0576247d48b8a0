"""`plinko ledger`: care of the database that a server keeps its rooms in."""

import time
from typing import Any

import click

from app.errors import SettingError
from app.settings import Settings

_DAY = 86400.0  # s


@click.group(name="ledger", short_help="Take care of a stopped server's ledger.")
def command() -> None:
    """Take care of the ledger of a server that does not run now."""


@command.command(name="prune")
@click.option("--keep-days", type=click.FloatRange(min=0.0), required=True, metavar="X",
              help="Rooms that were closed longer ago go.")  # fmt: skip
@click.option("--database-url", metavar="URL", help="The ledger, as `plinko serve` has it.")
@click.option("--data", metavar="DIR", help="The data directory, as `plinko serve` has it.")
@click.option("--dry-run", is_flag=True, help="Say what would go, and leave it.")
def prune(keep_days: float, dry_run: bool, **flags: Any) -> None:
    """Delete closed rooms with their drops, inputs and results.

    What is open stays, however old: it can be replayed as long as it is there. Boards stay.
    """
    from app.persistence import store
    from app.persistence.database import Database

    url = Settings.load(overrides=flags).ledger_url
    database = Database(url)
    if database.in_memory or (database.file is not None and not database.file.exists()):
        raise SettingError(f"there is no ledger {database.name}", field="database_url")
    database.open()
    try:
        with database.transaction() as connection:
            gone = store.prune(connection, time.time() - keep_days * _DAY, keep=dry_run)
        if not dry_run:
            database.compact()
    finally:
        database.close()
    would = "would be deleted" if dry_run else "deleted"
    click.echo(f"{gone.rooms} closed rooms, {gone.drops} drops, {gone.inputs} inputs {would}")
