"""`plinko ledger`: check, clean and restore the ledger, the database of a server, and its key."""

import collections
import contextlib
import dataclasses
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from plinko.app.cli.common import echo, need_server, print_json
from plinko.app.errors import SettingError, UnknownRoomError
from plinko.app.settings import Settings
from plinko.engine.errors import shorten

if TYPE_CHECKING:
    from plinko.app.persistence.ledger.database import Database
    from plinko.app.persistence.restoring import Restored

Command = TypeVar("Command", bound=Callable[..., object])

EXIT_DAMAGED = 1

_DAY = 86400.0  # s


@click.group(name="ledger", short_help="Back up, check, clean or restore a server's ledger.")
def command() -> None:
    """Back up, check, clean or restore a ledger; only `backup` works while its server runs."""
    need_server()


def _which(command: Command) -> Command:
    """Add --data and --database-url, which name the ledger; open it with `_opened`."""
    data = click.option("--data", metavar="DIR", help="The data directory, as for `plinko serve`.")
    url = click.option("--database-url", metavar="URL", help="The ledger, as for `plinko serve`.")
    return url(data(command))


@contextlib.contextmanager
def _opened(settings: Settings, *, check: bool = True) -> Iterator["Database"]:
    """Open the ledger of these settings; raises SettingError if it is missing or in use.

    check: refuse a ledger that is not as its server left it, such as a restored backup.
    """
    from plinko.app.persistence.ledger.database import Database

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
              help="Delete drops and closed rooms older than X days.")  # fmt: skip
@click.option("--dry-run", is_flag=True, help="Only count what would be deleted.")
@_which
def prune(keep_days: float, dry_run: bool, **flags: object) -> None:
    """Delete old drops, with their results and receipts, and rooms that were closed long ago.

    The same as the setting `retention` of a running server. Open rooms stay, without their old
    drops, and so do the drops of open fair sessions, boards, sums, and the log of receipts.
    """
    from plinko.app.persistence.statements import retention
    from plinko.app.rooms.records import Prune

    before, gone = time.time() - keep_days * _DAY, collections.Counter[str]()
    with _opened(Settings.load(overrides=flags)) as database:
        with database.transaction() as connection:
            steps = [Prune(run, before) for run in retention.runs(connection, before)]
            for step in steps:
                retention.prune(connection, [step])
                gone.update(rooms=step.rooms, drops=step.drops, inputs=step.inputs)
                if step.next is not None:
                    steps.append(Prune(step.run, before, step.next))
            if dry_run:
                connection.rollback()
        if not dry_run:
            database.compact()
    would = "would be deleted" if dry_run else "deleted"
    counts = f"{gone['rooms']} closed rooms, {gone['drops']} drops, {gone['inputs']} inputs"
    echo(f"{counts} {would}")


@command.command(name="backup")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--secrets", type=click.Path(path_type=Path), metavar="FILE",
              help="Write the server's secrets into this tar file.")  # fmt: skip
@_which
def backup(file: Path, secrets: Path | None, **flags: object) -> None:
    """Copy the ledger to FILE, while its server runs or not.

    The copy is that of one moment, and `plinko ledger check` can read it. Secrets are not in it:
    keep them apart. For PostgreSQL the command only says how to run pg_dump.
    """
    from plinko.app.persistence import backup as copies
    from plinko.app.persistence.ledger.database import Database

    settings = Settings.load(overrides=flags)
    database = Database(settings.ledger_url)
    found = copies.secrets_of(database, settings.data_directory)
    names = ", ".join(each.name for each in found) or "none"
    if secrets is not None:
        copies.back_up_secrets(found, secrets)
        echo(f"{secrets}: {names}")
    size = copies.back_up(database, file)
    echo(f"{file}: {size:,} bytes")
    if secrets is None:
        echo(f"secrets are left out: {names} (--secrets FILE)")


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
    from plinko.app.persistence.checks.audit import Audit
    from plinko.app.persistence.checks.integrity import check_database
    from plinko.app.persistence.statements import store

    audit = Audit()
    with _opened(Settings.load(overrides=flags), check=False) as database:
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


@command.command(name="actions")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@_which
def actions(as_json: bool, **flags: object) -> None:
    """Print the log of what the operator has done, the first action first."""
    from plinko.app.persistence.statements import store

    with (
        _opened(Settings.load(overrides=flags), check=False) as database,
        database.transaction() as connection,
    ):
        orders = store.orders(connection)
    if as_json:
        print_json({"actions": [dataclasses.asdict(order) for order in orders]})
        return
    for order in orders:
        until = f" until {_utc(order.until)}" if order.until is not None else ""
        what = " ".join(word for word in (order.action, order.subject, order.text) if word)
        echo(f"{_utc(order.time)} {what}{until}")


def _utc(time_: float) -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time_))


@command.command(name="retire")
@click.argument("room", metavar="ROOM")
@_which
def retire(room: str, **flags: object) -> None:
    """Give up a room that the server could not restore and that cannot be repaired.

    Its rows and results stay. Drops without a result land now; if one cannot be computed, it
    returns its stake. A preset's room or `main` starts again at the next request for it; a created
    room is closed.
    """
    from plinko.app.persistence.recovery import ending

    with _opened(Settings.load(overrides=flags)) as database, database.transaction() as connection:
        ended = ending.retire(connection, room, time.time())
    if ended is None:
        raise UnknownRoomError(f"the ledger has no open room {shorten(room)}", field="room")
    echo(
        f"{ended.room}, run {ended.session}: ended; {ended.landed} balls landed and pay "
        f"{ended.paid}; {ended.void} cannot be computed and return {ended.returned}"
    )


@command.command(name="restore")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@_which
def restore(as_json: bool, **flags: object) -> None:
    """Continue with a restored backup, a copy, or a ledger that has lost commits.

    A server refuses to start with such a ledger. All open fair sessions end, and their secrets are
    revealed: players have seen what comes next. Drops that the ledger lacks are void. A new log of
    receipts begins, with a signed statement that names the end of the former one.
    """
    restored = restore_ledger(Settings.load(overrides=flags))
    if as_json:
        print_json({"statement": restored.statement.to_dict(), "signature": restored.signature})
        return
    for line in lines_of(restored):
        echo(line)


def restore_ledger(settings: Settings) -> "Restored":
    """Restore the ledger of these settings; raises SettingError."""
    from plinko.app.persistence import restoring
    from plinko.app.persistence.signing_key import SigningKey

    with _opened(settings, check=False) as database:
        key = SigningKey(database, settings.data_directory)
        key.settle(time.time())
        return restoring.restore(database, key.signer, time.time())


def lines_of(restored: "Restored") -> list[str]:
    """What a restore did, for people."""
    said = restored.statement
    reason = restored.difference or "it is the ledger that the server left"
    return [
        f"before: {reason}",
        f"sessions: {said.sessions} open ones ended, with their secrets revealed; drops that the "
        "ledger lacks are void",
        f"log: {said.log} begins; the former one ends with {said.size} receipts and the root "
        f"{said.root}",
        "keys of requests: those from before are closed",
        f"signed: {restored.signature}",
    ]


@command.command(name="rotate-key")
@click.option("--lost", is_flag=True, help="The former key is lost, so it signs nothing.")
@_which
def rotate_key(lost: bool, **flags: object) -> None:
    """Sign with a new key from now on. Open fair sessions end; their drops land and are paid.

    The ledger keeps all public keys, and exports have those that they need, so all receipts stay
    provable. Each change of the key is signed by both keys.
    """
    from plinko.app.persistence.signing_key import SigningKey

    settings = Settings.load(overrides=flags)
    with _opened(settings) as database:
        public, ended = SigningKey(database, settings.data_directory).change(time.time(), lost=lost)
    echo(f"the server's public key is {public}; {ended} open sessions ended")
