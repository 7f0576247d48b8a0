"""Opening the ledger's database: its address, who may use it, its tables brought up to date."""

import contextlib
import fcntl
import os
import secrets
import socket
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import Connection, Engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, NoSuchModuleError
from sqlalchemy.pool import NullPool, StaticPool

from app.errors import LedgerError, SettingError
from app.persistence.ledger.fence import Fence
from app.persistence.statements import writer_store

HEAD = "0005"  # the last step of `migrations`

_PATIENCE = 5  # s that a database may take to answer
_LOCK = 0x706C696E6B6F  # 'plinko', the key of PostgreSQL's advisory lock
_MAKING = _LOCK + 1  # of the lock under which tables are made
_MAKING_PATIENCE = 60  # s
_IDLE = 2  # s that a server may leave a transaction open; before, others take none of its rooms
_LOCK_PATIENCE = 1  # s that the server before may take to let go of it
_LOCK_NOT_AVAILABLE = "55P03"  # PostgreSQL's error code


class InDoubtError(Exception):
    """A COMMIT may have reached the database, and no answer came."""


def address(url: str) -> URL:
    """The address of a database; raises SettingError naming what is wrong, never a password."""
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise SettingError(
            "database_url is no address such as sqlite:///plinko.db or postgresql://user@host/name",
            field="database_url",
        ) from None
    kind = parsed.get_backend_name()
    if kind == "postgresql":
        return parsed.set(drivername="postgresql+psycopg")
    if kind != "sqlite" or parsed.query:
        raise SettingError(
            f"database_url {parsed.render_as_string()} is neither sqlite:///FILE, sqlite:// "
            "(in memory) nor postgresql://…",
            field="database_url",
        )
    return parsed


class Database:
    """One database and the one connection that the ledger's writer works over.

    `shared`: with other servers that say so too, on PostgreSQL. Blocking, and for one thread at a
    time. `connect` and `transaction` raise SQLAlchemy's errors, OSError, and LedgerError for a
    database that is there but cannot be used.
    """

    def __init__(self, url: str, *, shared: bool = False) -> None:
        self.url = address(url)
        self.name = self.url.render_as_string(hide_password=True)
        self.shared = shared
        if self.url.get_backend_name() == "sqlite":
            self._engine = _sqlite(self.url)
        else:
            self._engine = _postgres(self.url, shared=shared)
        if shared and self._engine.dialect.name != "postgresql":
            raise SettingError(
                f"servers cannot share {self.name}: a ledger that several use is on "
                "PostgreSQL, and a server that has its ledger alone has no --name",
                field="database_url",
            )
        self._connection: Connection | None = None
        self._backend: writer_store.Backend | None = None  # PostgreSQL's process of the last one
        self._socket: tuple[int, int] | None = None  # descriptor and inode of its line
        self._writer = secrets.token_hex(16)  # this server's name in the table of writers
        self._epoch = 0
        self._batch = 0  # the number of the last one that is known to be there
        self._inode: tuple[int, int] | None = None
        self._lock: int | None = None
        self._fence: Fence | None = None
        self.is_open = False

    @property
    def in_memory(self) -> bool:
        """Whether all of it is gone with the process."""
        return self.url.get_backend_name() == "sqlite" and self.url.database in (None, ":memory:")

    @property
    def file(self) -> Path | None:
        if self.url.get_backend_name() != "sqlite" or self.in_memory:
            return None
        return Path(str(self.url.database))

    @property
    def secret_file(self) -> Path | None:
        """Where a server over this database keeps its secret; None but for SQLite's file."""
        return None if self.file is None else self.file.with_name(f"{self.file.name}-secret")

    def open(self) -> None:
        """Connect for the first time and bring the tables up to date.

        Raises SettingError naming the database when that cannot be done.
        """
        try:
            if self.file is not None:
                self.file.parent.mkdir(0o700, parents=True, exist_ok=True)
                # As SQLite does: one file has one write-ahead log and one lock, whatever the links
                # by which it is reached.
                file = self.file.resolve()
                _check_one_name(file)
                self._lock = _lock_file(file)
                self._fence = Fence(file)
                self._fence.check_presence()
                _own(file)
            connection = self._connected()
            if self._fence is not None:
                self._fence.open(connection)
            migrate(connection)
            with connection.begin():
                writer_store.enter(connection, self._writer, alone=not self.shared)
            self._batch = self._epoch = 0
        except (sa.exc.SQLAlchemyError, OSError, LedgerError) as error:
            self.close()
            raise SettingError(
                f"the ledger {self.name} cannot be opened: {reason(error)}", field="database_url"
            ) from error
        if self.file is not None:
            self._inode = _inode(self.file)
        self.is_open = True

    @contextlib.contextmanager
    def transaction(self) -> Iterator[Connection]:
        """A transaction, committed at the end of the block, undone when the block raises.

        After an error the connection is given up: what it was in the middle of is not known.
        """
        try:
            if self._inode is not None and self.file is not None:
                self._check_file(self.file)
            connection = self._connected()
            with connection.begin():
                if self._fence is not None:
                    self._fence.begin(connection)
                yield connection
                if self._fence is not None:
                    self._fence.count(connection)
        except BaseException:
            self.disconnect()
            raise
        if self._fence is not None:
            self._fence.committed()

    @contextlib.contextmanager
    def batch(self) -> Iterator[Connection]:
        """A transaction with a number; after InDoubtError `has_batch` says whether it is there.

        Any other error means that it is not, and never will be: no COMMIT was sent.
        """
        whole = False
        try:
            with self.transaction() as connection:
                writer_store.count(connection, self._writer, self._epoch, self._batch + 1)
                yield connection
                whole = True
        except Exception as error:
            if whole:
                raise InDoubtError(reason(error)) from error
            raise
        self._batch += 1

    def has_batch(self) -> bool:
        """Whether the batch in doubt is there, which is final: read over a new connection.

        Its transaction has locked the writer's row before all else, so reading that row waits for
        its end. With the epoch raised, nothing more can come over the former connection.
        """
        self.disconnect()
        with self.transaction() as connection:
            found, epoch = writer_store.renew(connection, self._writer)
        there, self._batch, self._epoch = found > self._batch, found, epoch
        if there and self._fence is not None:
            self._fence.committed()
        return there

    def cut(self) -> None:
        """End the wait for an answer that does not come; for any thread. SQLite's waits all end."""
        if self._socket is None:
            return
        descriptor, inode = self._socket
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as line:
            if os.fstat(line.fileno()).st_ino == inode:  # else it was closed meanwhile
                line.shutdown(socket.SHUT_RDWR)

    def compact(self) -> None:
        """Give the room of deleted rows back to the file system; PostgreSQL does so by itself."""
        if self.file is not None:
            connection = self._connected().connection.driver_connection
            assert connection is not None
            connection.execute("VACUUM")

    def disconnect(self) -> None:
        """Give up the connection; the next transaction makes a new one. Memory has only one."""
        if self._connection is None or self.in_memory:
            return
        connection, self._connection = self._connection, None
        with contextlib.suppress(sa.exc.SQLAlchemyError):
            connection.invalidate()
        with contextlib.suppress(sa.exc.SQLAlchemyError):
            connection.close()

    def close(self) -> None:
        """Close the connection and let other servers have the database."""
        if self._connection is not None:
            with contextlib.suppress(sa.exc.SQLAlchemyError):
                self._connection.close()
            self._connection = None
        self._engine.dispose()
        self.is_open = False
        if self._fence is not None:
            self._fence.close()
            self._fence = None
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _connected(self) -> Connection:
        if self._connection is None:
            connection = self._engine.connect()
            if self._engine.dialect.name == "postgresql":
                backend = writer_store.succeed(connection, self._backend)
                _lock_database(connection, shared=self.shared)
                self._backend, self._socket = backend, _socket_of(connection)
            self._connection = connection
        return self._connection

    def _check_file(self, file: Path) -> None:
        """Raise LedgerError when the file is no longer the one that is open.

        SQLite would go on writing into a file that was deleted, and nothing of it would remain.
        """
        if _inode(file) != self._inode:
            raise LedgerError(f"{file} was replaced by another file; start the server again")


def reason(error: BaseException) -> str:
    """What a database's error says, without the statement and its values."""
    if isinstance(error, sa.exc.DBAPIError) and error.orig is not None:
        error = error.orig
    return " ".join(str(error).split()) or type(error).__name__


def migrate(connection: Connection) -> None:
    """Bring the tables up to date; raises LedgerError when they are of a later release.

    Servers that share the database do so one after another.
    """
    if _revision(connection) == HEAD:
        return
    if connection.dialect.name != "postgresql":
        _upgrade(connection)
        return
    with connection.begin():
        connection.execute(sa.text(f"SET LOCAL statement_timeout = '{_MAKING_PATIENCE}s'"))
        connection.execute(sa.text(f"SELECT pg_advisory_lock({_MAKING})"))
    try:
        if _revision(connection) != HEAD:
            _upgrade(connection)
    finally:
        with connection.begin():
            connection.execute(sa.text(f"SELECT pg_advisory_unlock({_MAKING})"))


def _upgrade(connection: Connection) -> None:
    # Imported when there is something to do: a start that finds its tables does without.
    from alembic import command  # noqa: PLC0415
    from alembic.config import Config  # noqa: PLC0415
    from alembic.util import CommandError  # noqa: PLC0415

    config = Config()
    config.set_main_option("script_location", "app.persistence.ledger:migrations")
    config.attributes["connection"] = connection
    try:
        with connection.begin():
            if connection.dialect.name == "postgresql":
                # Nobody waits for these tables yet but servers that start, each as long.
                standing = f"SET LOCAL idle_in_transaction_session_timeout = '{_MAKING_PATIENCE}s'"
                connection.execute(sa.text(standing))
            command.upgrade(config, "head")
    except CommandError as error:
        raise LedgerError(
            f"its tables are of step {_revision(connection)!r}, this release knows those up to "
            f"{HEAD!r}: {error}"
        ) from error


def _revision(connection: Connection) -> str | None:
    """The step that the tables are at; None when there are none."""
    with connection.begin():
        if not sa.inspect(connection).has_table("alembic_version"):
            return None
        found: str | None = connection.execute(
            sa.text("SELECT version_num FROM alembic_version")
        ).scalar()
        return found


def reader(url: str) -> Engine:
    """Reads what servers have committed, from another process than theirs; it cannot write."""
    parsed = address(url)
    if parsed.get_backend_name() != "sqlite":
        return _postgres(parsed, shared=False).execution_options(postgresql_readonly=True)
    file = f"file:{quote(str(parsed.database))}?mode=rw"  # where there is none, none is made

    def connect() -> sqlite3.Connection:
        connection = sqlite3.connect(file, timeout=_PATIENCE, uri=True)
        connection.execute("PRAGMA query_only = ON")
        return connection

    return sa.create_engine("sqlite://", creator=connect, poolclass=NullPool)


def _sqlite(url: URL) -> Engine:
    in_memory = url.database in (None, ":memory:")
    engine = sa.create_engine(
        url,
        poolclass=StaticPool if in_memory else NullPool,
        connect_args={"check_same_thread": False, "timeout": _PATIENCE},
    )

    @event.listens_for(engine, "connect")
    def _prepare(connection: sqlite3.Connection, _: object) -> None:
        # Python's own idea of when a transaction begins leaves the tables' making outside of it.
        connection.isolation_level = None
        connection.execute("PRAGMA journal_mode = WAL")
        # A commit returns once it is on the disk, not once it is on its way there.
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA foreign_keys = ON")
        # Rows are added at the tables' ends and hardly ever read: a few hundred pages are enough.
        connection.execute("PRAGMA cache_size = -512")

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")

    return engine


def _postgres(url: URL, *, shared: bool) -> Engine:
    options = f"-c synchronous_commit=on -c statement_timeout={1000 * _PATIENCE}"
    if shared:
        # A server that freezes amid a transaction keeps the others from its rooms no longer.
        options += f" -c idle_in_transaction_session_timeout={1000 * _IDLE}"
    try:
        return sa.create_engine(
            url,
            poolclass=NullPool,
            connect_args={
                "connect_timeout": _PATIENCE,
                "keepalives_idle": 2 * _PATIENCE,
                "tcp_user_timeout": 1000 * _PATIENCE,
                "options": options,
                "application_name": "plinko",
            },
        )
    except (ImportError, NoSuchModuleError):
        raise SettingError(
            "PostgreSQL needs its driver: pip install 'plinko-server[postgres]'",
            field="database_url",
        ) from None


def _socket_of(connection: Connection) -> tuple[int, int]:
    """The descriptor of a connection to PostgreSQL, and the inode that it stands for."""
    driver = connection.connection.driver_connection
    assert driver is not None
    descriptor = driver.fileno()
    return descriptor, os.fstat(descriptor).st_ino


def _lock_database(connection: Connection, *, shared: bool) -> None:
    """Take PostgreSQL's lock, which goes with the connection; raises LedgerError when taken.

    Servers that share the database share the lock. Waits for a moment: the backend of a server
    that has just ended gives it up when it notices.
    """
    kind = "_shared" if shared else ""
    try:
        with connection.begin():
            connection.execute(sa.text(f"SET LOCAL lock_timeout = '{_LOCK_PATIENCE}s'"))
            connection.execute(sa.text(f"SELECT pg_advisory_lock{kind}({_LOCK})"))
    except sa.exc.OperationalError as error:
        connection.close()
        if getattr(error.orig, "sqlstate", None) != _LOCK_NOT_AVAILABLE:
            raise
        raise LedgerError(
            "another server uses it for itself alone" if shared else "another server uses it"
        ) from None


def _lock_file(file: Path) -> int:
    """Take the lock beside SQLite's file, which goes with the process.

    Not a lock on the file itself: closing a descriptor of it would drop SQLite's own locks.
    """
    descriptor = os.open(f"{file}-lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise LedgerError(
            "another server uses it; give this one a --data directory or --database-url of its own"
        ) from None
    return descriptor


def _own(file: Path) -> None:
    """Have SQLite's file be its owner's alone; the ones it makes beside it are like it."""
    os.close(os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600))
    for each in (file, Path(f"{file}-wal"), Path(f"{file}-shm")):
        # Not there yet, or another's, who lets this user write.
        with contextlib.suppress(FileNotFoundError, PermissionError):
            each.chmod(0o600)


def _check_one_name(file: Path) -> None:
    """Raise LedgerError for a file that has another name, under which another server may use it.

    Links to the file's name are followed. Behind a second name in a directory (a hard link) SQLite
    would keep a write-ahead log of its own, and what is in the first one's would be lost.
    """
    names = file.stat().st_nlink if file.exists() else 1
    if names > 1:
        raise LedgerError(
            f"the file has {names} names (hard links); a database must have one, so remove the "
            "others, or copy the file and use the copy"
        )


def _inode(file: Path) -> tuple[int, int]:
    found = file.stat()
    return found.st_dev, found.st_ino
