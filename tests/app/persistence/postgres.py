"""A PostgreSQL of the tests' own: a cluster in a temporary folder, reached by a Unix socket."""

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

from tests.waiting import LIMIT, until

MISSING = "PostgreSQL's server programs are not here: apt-get install postgresql"
NO_USER = "PostgreSQL refuses to run as root, and there is no user `postgres` to run it as"


def programs() -> Path | None:
    """The folder with initdb and postgres, the newest version's; None when there is none."""
    found = shutil.which("initdb")
    if found is not None and Path(found).with_name("postgres").exists():
        return Path(found).parent
    versions = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), reverse=True)
    return versions[0].parent if versions else None


def can_run() -> bool:
    """Whether there is a user to run it as: anyone but root."""
    if os.geteuid() != 0:
        return True
    try:
        pwd.getpwnam("postgres")
    except KeyError:
        return False
    return True


@dataclass
class Cluster:
    """A running PostgreSQL that can be killed and started again."""

    folder: Path
    binaries: Path
    user: str | None  # to run it as, where the tests run as root
    process: "subprocess.Popen[bytes] | None" = None
    _names: Iterator[int] = field(default_factory=count)

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

    def start(self) -> None:
        options = [f"-k{self.folder}", "-clisten_addresses=", "-cmax_connections=20"]
        # What is killed here is processes, whose files outlive them; no test pulls the plug.
        options += ["-cfsync=off"]
        self.process = subprocess.Popen(
            [self.binaries / "postgres", "-D", self.folder / "data", *options],
            user=self.user,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self.folder,
        )
        until(self._answers)

    def stop(self, how: signal.Signals = signal.SIGINT) -> None:
        """End it: SIGINT in order, SIGQUIT as in a crash."""
        if self.process is not None:
            self.process.send_signal(how)
            self.process.wait(LIMIT)
            self.process = None

    def _answers(self) -> bool:
        import psycopg

        assert self.process is not None
        assert self.process.poll() is None, "PostgreSQL ended while it was to start"
        try:
            psycopg.connect(self.url("postgres"), connect_timeout=5).close()
        except psycopg.OperationalError:
            return False
        return True


@contextlib.contextmanager
def running(binaries: Path) -> Iterator[Cluster]:
    """A new cluster, gone at the end. It refuses to run as root, and then runs as `postgres`."""
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
        cluster = Cluster(folder, binaries, user)
        cluster.start()
        try:
            yield cluster
        finally:
            cluster.stop(signal.SIGQUIT)  # in a hurry: nobody reads these files again
