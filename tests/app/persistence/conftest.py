"""Databases to keep a ledger in: SQLite's file, and a real PostgreSQL where it is installed."""

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.persistence.ledger.database import Database
from tests.kit.postgres import PostgreSQL
from tests.long import tries

KILLS = int(os.environ.get("PLINKO_TEST_KILLS", "50"))
"""How often a crash test kills its server: once as it was begun, once as it was found again."""

# Kinds of database to keep a ledger in, see the fixture `url`.
SQLITE = pytest.param("sqlite", id="sqlite")
POSTGRESQL = pytest.param("postgresql", id="postgresql", marks=pytest.mark.postgresql)


@pytest.fixture(params=[SQLITE, POSTGRESQL])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty database's address, of each kind in turn."""
    return new_database(request, tmp_path)


def new_database(request: pytest.FixtureRequest, folder: Path) -> str:
    """An empty database's address, of the kind that the fixture which asks is parametrized with."""
    if request.param == "sqlite":
        return f"sqlite:///{folder / 'plinko.db'}"
    postgresql: PostgreSQL = request.getfixturevalue("postgresql")
    return postgresql.new_database()


@pytest.fixture(scope="session")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ledger in SQLite's file, with its tables and nothing in them."""
    file = tmp_path_factory.mktemp("empty") / "plinko.db"
    database = Database(f"sqlite:///{file}")
    database.open()
    database.close()
    return file


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A real file system of a few megabytes."""
    with mounted(tmp_path / "disk", tries(1, 16)) as disk:
        yield disk


@pytest.fixture
def database_on_small_disk(postgresql: PostgreSQL) -> Iterator[tuple[str, Path]]:
    """An empty PostgreSQL database's address, and the disk of some megabytes that it is on."""
    # An empty database has 8 MB.
    with mounted(postgresql.folder / "disk", 64) as disk, postgresql.database_on(disk) as address:
        yield address, disk


@contextlib.contextmanager
def mounted(place: Path, megabytes: int) -> Iterator[Path]:
    """A real file system of so many megabytes at a new folder; skips where there can be none."""
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
