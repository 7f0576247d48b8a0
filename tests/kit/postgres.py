"""A private PostgreSQL for the tests, in a temporary folder, reached by a Unix socket."""

import contextlib
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import ClassVar

from tests.kit.process import Program
from tests.kit.waiting import LIMIT


def programs() -> Path | None:
    """The folder with initdb and postgres of the newest version; None if not installed."""
    found = shutil.which("initdb")
    if found is not None and Path(found).with_name("postgres").exists():
        return Path(found).parent
    versions = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), reverse=True)
    return versions[0].parent if versions else None


def why_not() -> str:
    """Why PostgreSQL cannot run here; empty if it can."""
    if programs() is None:
        return "PostgreSQL's server programs are not here: apt-get install postgresql"
    if os.geteuid() == 0:
        try:
            pwd.getpwnam("postgres")
        except KeyError:
            return "PostgreSQL refuses to run as root, and there is no user `postgres` for it"
    return ""


@dataclass(kw_only=True)
class PostgreSQL(Program):
    """A running PostgreSQL that can be killed and started again."""

    LAST: ClassVar = signal.SIGQUIT  # immediate shutdown: the files are deleted anyway

    folder: Path
    binaries: Path
    user: str | None  # runs as this user if the tests run as root
    _names: Iterator[int] = field(default_factory=count)

    def __post_init__(self) -> None:
        flags = [f"-k{self.folder}", "-clisten_addresses=", "-cmax_connections=60"]
        # Tests kill processes, never the operating system: data that was written stays in files.
        flags += ["-cfsync=off"]
        self.command = [self.binaries / "postgres", "-D", self.folder / "data", *flags]
        self.options = {**self.options, "user": self.user, "cwd": self.folder}
        self.answers = self._answers

    def url(self, database: str) -> str:
        return f"postgresql://plinko@/{database}?host={self.folder}"

    def new_database(self) -> str:
        """Create an empty database; returns its address."""
        return self.url(self._create_database())

    @contextlib.contextmanager
    def database_on(self, disk: Path) -> Iterator[str]:
        """Create an empty database with its tables on this disk and its log elsewhere.

        Gives its address. The end of the block drops it, so that the disk can be unmounted.
        """
        if self.user is not None:
            shutil.chown(disk, self.user)
        self._execute(f"CREATE TABLESPACE small LOCATION '{disk}'")
        name = self._create_database("TABLESPACE small")
        try:
            yield self.url(name)
        finally:
            self._execute(f"DROP DATABASE {name} WITH (FORCE)", "DROP TABLESPACE small")

    def _create_database(self, options: str = "") -> str:
        name = f"plinko_{next(self._names)}"
        self._execute(f"CREATE DATABASE {name} {options}")
        return name

    def _execute(self, *statements: str) -> None:
        import psycopg

        with psycopg.connect(self.url("postgres"), autocommit=True) as connection:
            for statement in statements:
                connection.execute(statement.encode())

    def _answers(self) -> bool:
        import psycopg

        try:
            psycopg.connect(self.url("postgres"), connect_timeout=5).close()
        except psycopg.OperationalError:
            return False
        return True


@contextlib.contextmanager
def running() -> Iterator[PostgreSQL]:
    """A new PostgreSQL. It refuses to run as root, so root runs it as user `postgres`."""
    binaries = programs()
    assert binaries is not None
    user = "postgres" if os.geteuid() == 0 else None
    with tempfile.TemporaryDirectory(prefix="plinko-pg-") as name:
        folder = Path(name)
        if user is not None:
            shutil.chown(folder, user)
        subprocess.run(
            [binaries / "initdb", "-D", folder / "data", "-U", "plinko", "-A", "trust", "-N"],
            user=user,
            check=True,
            capture_output=True,
            cwd=folder,
            timeout=LIMIT,
        )
        with PostgreSQL(folder=folder, binaries=binaries, user=user) as postgresql:
            yield postgresql
