"""Copies the ledger of a running server, and its secrets apart from it."""

import contextlib
import os
import shlex
import sqlite3
import tarfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from plinko.app.errors import SettingError
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.signing_key import secret_file


def back_up(database: Database, target: Path) -> int:
    """Copy SQLite's file as it is at one moment; returns the size in bytes.

    The server writes on meanwhile. Raises SettingError, for PostgreSQL with the command to run.
    """
    if database.file is None:
        url = shlex.quote(database.url.set(drivername="postgresql").render_as_string())
        raise SettingError(
            f"back up PostgreSQL with its own program: pg_dump --format=custom --file="
            f"{shlex.quote(str(target))} {url}",
            field="database_url",
        )
    with _written(target) as draft, contextlib.closing(_opened(database.file)) as ledger:
        with contextlib.closing(sqlite3.connect(draft)) as copy:
            ledger.backup(copy)
            # One file: without it a reader would make a write-ahead log next to the copy.
            copy.execute("PRAGMA journal_mode = DELETE")
            (found,) = copy.execute("PRAGMA quick_check(1)").fetchone()
        if found != "ok":
            raise SettingError(f"the copy of {database.name} is damaged: {found}", field="file")
    return target.stat().st_size


def secrets_of(database: Database, directory: Path | None) -> list[Path]:
    """The files with the server's secrets that exist."""
    file = secret_file(database, directory)
    files = [] if file is None else [file, file.with_name(f"{file.name}-signing-key")]
    return [each for each in files if each.exists()]


def back_up_secrets(files: Sequence[Path], target: Path) -> None:
    """Write these files into a tar archive, which only its owner can read."""
    with _written(target) as draft, tarfile.open(draft, "w") as archive:
        for each in files:
            archive.add(each, each.name)


@contextlib.contextmanager
def _written(target: Path) -> Iterator[Path]:
    """A private file that becomes `target`, complete and on the disk, or is deleted."""
    if target.exists():
        raise SettingError(f"{target} exists: name a new file", field="file")
    draft = target.with_name(f"{target.name}.part")
    try:
        os.close(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600))
        yield draft
        with draft.open("rb") as written:
            os.fsync(written.fileno())
        draft.rename(target)
    except (OSError, sqlite3.Error) as error:
        raise SettingError(f"{target} cannot be written: {error}", field="file") from error
    finally:
        draft.unlink(missing_ok=True)


def _opened(file: Path) -> sqlite3.Connection:
    if not file.exists():
        raise SettingError(f"there is no ledger {file}", field="database_url")
    return sqlite3.connect(f"{file.resolve().as_uri()}?mode=rw", uri=True)
