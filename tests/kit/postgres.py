"""A PostgreSQL of the tests' own, in a temporary folder, reached by a Unix socket."""

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
    """The folder with initdb and postgres, the newest version's; None when there is none."""
    found = shutil.which("initdb")
    if found is not None and Path(found).with_name("postgres").exists():
        return Path(found).parent
    versions = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), reverse=True)
    return versions[0].parent if versions else None


def why_not() -> str:
    """Why there can be none here; empty if it can."""
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

    LAST: ClassVar = signal.SIGQUIT  # in a hurry: nobody reads its files again

    folder: Path
    binaries: Path
    user: str | None  # to run it as, where the tests run as root
    _names: Iterator[int] = field(default_factory=count)

    def __post_init__(self) -> None:
        flags = [f"-k{self.folder}", "-clisten_addresses=", "-cmax_connections=60"]
        # What is killed here is processes, whose files outlive them; no test pulls the plug.
        flags += ["-cfsync=off"]
        self.command = [self.binaries / "postgres", "-D", self.folder / "data", *flags]
        self.options = {**self.options, "user": self.user, "cwd": self.folder}
        self.answers = self._answers

    def url(self, database: str) -> str:
        return f"postgresql://plinko@/{database}?host={self.folder}"

    def new_database(self) -> str:
        """An empty database; returns its address."""
        return self.url(self._create_database())

    @contextlib.contextmanager
    def database_on(self, disk: Path) -> Iterator[str]:
        """An empty database whose tables, but not its log, are on this disk; its address.

        All of it is gone in the end, so that the disk can be taken away.
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
    """A new one, gone at the end. It refuses to run as root, and then runs as `postgres`."""
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
