"""Databases for a ledger: an SQLite file, and a real PostgreSQL if installed."""

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from plinko.app.persistence.ledger.database import Database
from tests.kit.postgres import PostgreSQL
from tests.long import tries

KILLS = int(os.environ.get("PLINKO_TEST_KILLS", "50"))
"""How often a crash test kills its server."""

# Kinds of database; see the fixture `url`.
SQLITE = pytest.param("sqlite", id="sqlite")
POSTGRESQL = pytest.param("postgresql", id="postgresql", marks=pytest.mark.postgresql)
LATER = pytest.param(
    "postgresql",
    id="postgresql",
    marks=[pytest.mark.postgresql, pytest.mark.long("what PostgreSQL does here, others show")],
)
"""PostgreSQL where a neighbouring test runs the same statements on it in every run."""

on_sqlite = pytest.mark.parametrize("url", [SQLITE], indirect=True)
"""For tests that do not depend on the kind of database."""
on_sqlite_first = pytest.mark.parametrize("url", [SQLITE, LATER], indirect=True)


@pytest.fixture(params=[SQLITE, POSTGRESQL])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of an empty database; the test runs once for each kind."""
    return new_database(request, tmp_path)


def new_database(request: pytest.FixtureRequest, folder: Path) -> str:
    """The address of an empty database of the kind in the fixture's `request.param`."""
    if request.param == "sqlite":
        return f"sqlite:///{folder / 'plinko.db'}"
    postgresql: PostgreSQL = request.getfixturevalue("postgresql")
    return postgresql.new_database()


@pytest.fixture(scope="session")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An SQLite file with the ledger's empty tables, for tests to copy."""
    file = tmp_path_factory.mktemp("empty") / "plinko.db"
    database = Database(f"sqlite:///{file}")
    database.open(enter=False)  # a copy is not refused: it belongs to no server yet
    database.close()
    return file


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A real file system of a few megabytes."""
    with mounted(tmp_path / "disk", tries(1, 16)) as disk:
        yield disk


@pytest.fixture
def database_on_small_disk(postgresql: PostgreSQL) -> Iterator[tuple[str, Path]]:
    """The address of an empty PostgreSQL database on a small disk, and the disk."""
    # An empty database has 8 MB.
    with mounted(postgresql.folder / "disk", 64) as disk, postgresql.database_on(disk) as address:
        yield address, disk


@contextlib.contextmanager
def mounted(place: Path, megabytes: int) -> Iterator[Path]:
    """Mount a tmpfs of this size at a new folder; skips the test if that is impossible."""
    place.mkdir()
    mount = shutil.which("mount")
    done = subprocess.run(
        [mount or "false", "-t", "tmpfs", "-o", f"size={megabytes}m", "plinko-test", place],
        capture_output=True,
        check=False,
    )
    if done.returncode:
        pytest.skip("mounting a small tmpfs needs root")
    try:
        yield place
    finally:
        subprocess.run(["umount", place], check=True)
        place.rmdir()
