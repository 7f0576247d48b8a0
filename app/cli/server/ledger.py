"""`plinko ledger`: check and clean the ledger, the database in which a server keeps its rooms."""

import contextlib
import dataclasses
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, TypeVar

import click

from app.cli.common import echo, need_server, print_json
from app.errors import SettingError, UnknownRoomError, shorten
from app.settings import Settings

if TYPE_CHECKING:
    from app.persistence.ledger.database import Database

Command = TypeVar("Command", bound=Callable[..., object])

EXIT_DAMAGED = 1

_DAY = 86400.0  # s


@click.group(name="ledger", short_help="Check or clean a stopped server's ledger.")
def command() -> None:
    """Check or clean the ledger of a server that is not running."""
    need_server()


def _which(command: Command) -> Command:
    """Add --data and --database-url, which name the ledger; open it with `_opened`."""
    data = click.option("--data", metavar="DIR", help="The data directory, as for `plinko serve`.")
    url = click.option("--database-url", metavar="URL", help="The ledger, as for `plinko serve`.")
    return url(data(command))


@contextlib.contextmanager
def _opened(flags: dict[str, object], *, check: bool = True) -> Iterator["Database"]:
    """Open the ledger of the options; raises SettingError if it is missing or in use.

    check: refuse a ledger that is not as its server left it, such as a restored backup.
    """
    from app.persistence.ledger.database import Database

    settings = Settings.load(overrides=flags)
    database = Database(settings.ledger_url, beside=settings.epoch_file)
    if database.in_memory or (database.file is not None and not database.file.exists()):
        raise SettingError(
            f"there is no ledger {database.name}: name it with --data or --database-url",
            field="database_url",
        )
    database.open(check=check, enter=False)
    try:
        yield database
    finally:
        database.close()


@command.command(name="prune")
@click.option("--keep-days", type=click.FloatRange(min=0.0), required=True, metavar="X",
              help="Delete rooms closed more than X days ago.")  # fmt: skip
@click.option("--dry-run", is_flag=True, help="Only count what would be deleted.")
@_which
def prune(keep_days: float, dry_run: bool, **flags: object) -> None:
    """Delete closed rooms with their drops, inputs and results.

    Open rooms stay, however old, so that they can be replayed. Boards stay too.
    """
    from app.persistence.statements import store

    with _opened(flags) as database:
        with database.transaction() as connection:
            gone = store.prune(connection, time.time() - keep_days * _DAY, keep=dry_run)
        if not dry_run:
            database.compact()
    would = "would be deleted" if dry_run else "deleted"
    echo(f"{gone.rooms} closed rooms, {gone.drops} drops, {gone.inputs} inputs {would}")


@command.command(name="check")
@click.argument("rooms", metavar="[ROOM]...", nargs=-1)
@click.option("--replay", is_flag=True, help="Replay open rooms from their first tick.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@_which
def check(rooms: tuple[str, ...], replay: bool, as_json: bool, **flags: object) -> int:
    """Check the record of every room, or of the given rooms.

    The check looks for gaps in the numbering, compares boards with their digests, recomputes every
    result and payout, and rebuilds each open room. Exit code 0: all is sound; 1: something is
    damaged, which the output names; 2: the ledger is missing or cannot be opened.
    """
    from app.persistence.checks.audit import Audit
    from app.persistence.checks.integrity import check_database
    from app.persistence.statements import store

    audit = Audit()
    with _opened(flags, check=False) as database:
        pages = check_database(database)
        with database.transaction() as connection:
            numbers = store.run_numbers(connection, rooms)
        for number in numbers:
            audit.look(database, number, replay=replay)
        name = database.name
    sound = not pages and not audit.findings
    if as_json:
        print_json({"ledger": name, "sound": sound, "database": pages, **dataclasses.asdict(audit)})
    else:
        for line in pages:
            echo(f"the database: {line}")
        for found in audit.findings:
            echo(f"{found.room}, run {found.session}: {found.what}")
        echo(
            f"{'sound' if sound else 'damaged'}: {audit.sessions} room runs, {audit.drops} drops, "
            f"{audit.results} results, {audit.inputs} inputs"
        )
        if audit.other_physics:
            echo(
                f"{audit.other_physics} room runs have another physics version: of their drops "
                "only the payouts were checked"
            )
    return 0 if sound else EXIT_DAMAGED


@command.command(name="retire")
@click.argument("room", metavar="ROOM")
@_which
def retire(room: str, **flags: object) -> None:
    """Give up a room that the server could not restore and that cannot be repaired.

    Its rows and results stay; drops without a result get their stake back. A preset's room or
    `main` starts again at the next request for it; a created room is closed.
    """
    from app.persistence.recovery import ending

    with _opened(flags) as database, database.transaction() as connection:
        ended = ending.retire(connection, room, time.time())
    if ended is None:
        raise UnknownRoomError(f"the ledger has no open room {shorten(room)}", field="room")
    echo(
        f"{ended.room}, run {ended.session}: ended; {ended.drops} drops without a result, "
        f"{ended.stakes} returned"
    )
