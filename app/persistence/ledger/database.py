"""Opens the ledger's database: parses its address, locks it, checks it, and migrates its tables."""

import contextlib
import errno
import fcntl
import os
import re
import secrets
import socket
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import Connection, Engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, NoSuchModuleError
from sqlalchemy.pool import NullPool, StaticPool

from plinko.app.errors import LedgerError, LedgerInUseError, SettingError, StartError
from plinko.app.persistence.ledger.epoch import EpochFile, Place
from plinko.app.persistence.statements import history, tables, writer_store

HEAD = "0006"  # the last step of `migrations`

_LOG_BYTES = 1 << 24  # of SQLite's write-ahead log that stay after a checkpoint
_ANSWER_SECONDS = 5  # how long the database may take to answer
_LOCK = 0x706C696E6B6F  # 'plinko', the key of PostgreSQL's advisory lock
_MIGRATION_LOCK = _LOCK + 1
_MIGRATION_SECONDS = 60  # how long a migration, or the wait for another server's, may take
# How long a transaction of a server that shares the ledger may stay idle. Until it ends, other
# servers cannot take the rooms that it has written.
_IDLE_SECONDS = 2
_LOCK_SECONDS = 1  # how long to wait until the former server's lock is released
_LOCK_NOT_AVAILABLE = "55P03"  # PostgreSQL's error code
_REFUSAL = re.compile("authentication failed|does not exist|pg_hba|unable to open")
"""In the message of a database that refuses these settings, and will refuse them again."""
_FULL = frozenset({errno.ENOSPC, errno.EDQUOT})


class InDoubtError(Exception):
    """A COMMIT may have reached the database, but no answer came."""


def address(url: str) -> URL:
    """Parse a database's address; raises SettingError, whose message contains no password."""
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise SettingError(
            "database_url is not an address such as sqlite:///plinko.db or "
            "postgresql://user@host/name",
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
    """The ledger's database, and its one connection for writing.

    All calls block, and only one thread may use the object at a time. `shared`: other servers use
    the same database too (PostgreSQL only). `beside`: the file with this server's epoch; SQLite's
    is always next to its own file. Transactions raise SQLAlchemy's errors, OSError, and LedgerError
    for a database that exists but cannot be used.
    """

    def __init__(self, url: str, *, shared: bool = False, beside: Path | None = None) -> None:
        self.url = address(url)
        self.name = self.url.render_as_string(hide_password=True)
        self.shared = shared
        if self.url.get_backend_name() == "sqlite":
            self._engine = _sqlite(self.url)
        else:
            self._engine = _postgres(self.url, shared=shared)
        if shared and self._engine.dialect.name != "postgresql":
            raise SettingError(
                f"servers cannot share {self.name}: use a ledger on PostgreSQL, or omit --name "
                "if only this server uses the ledger",
                field="database_url",
            )
        self._connection: Connection | None = None
        self._backend: writer_store.Backend | None = None  # that of the last connection
        self._socket: tuple[int, int] | None = None  # descriptor and inode of its socket
        self._epoch = ""  # the name of this start in the table `writers`
        self._reconnects = 0
        self._batch = 0  # number of the last batch that is known to be durable
        self._inode: tuple[int, int] | None = None
        self._lock: int | None = None
        self.outdated = ""  # what a later release has done to the tables since `open`
        if self.file is not None:
            # Follow symbolic links as SQLite does, so that a database has one lock and one epoch,
            # whichever link leads to it.
            file = self.file.resolve()
            beside = file.with_name(f"{file.name}-epoch")
        self._beside = None if beside is None or self.in_memory else EpochFile(beside)
        self.is_open = False

    @property
    def in_memory(self) -> bool:
        """Whether the database ends with the process."""
        return self.url.get_backend_name() == "sqlite" and self.url.database in (None, ":memory:")

    @property
    def file(self) -> Path | None:
        if self.url.get_backend_name() != "sqlite" or self.in_memory:
            return None
        return Path(str(self.url.database))

    @property
    def log_bytes(self) -> int:
        """The size of SQLite's write-ahead log; 0 for other databases."""
        log = None if self.file is None else Path(f"{self.file.resolve()}-wal")
        return log.stat().st_size if log is not None and log.exists() else 0

    def open(self, *, check: bool = True, enter: bool = True) -> None:
        """Lock the database, connect, migrate the tables, and begin an epoch; raises SettingError.

        check: refuse a ledger that is not as this server left it. Without `enter`, only
        `transaction` works: batches belong to an epoch.
        """
        try:
            if self.file is not None:
                self.file.parent.mkdir(0o700, parents=True, exist_ok=True)
                file = self.file.resolve()
                _check_one_name(file)
                self._lock = _lock_file(file)
                if check and self._beside is not None and not file.exists() and self._beside.read():
                    raise LedgerError(
                        f"the file is missing, but {self._beside.path}, which belongs to it, is "
                        f"there: put the file back, or delete {self._beside.path.name} to begin an "
                        "empty ledger"
                    )
                _make_private(file)
            self._connected()
            if check and (difference := self.difference()):
                raise LedgerError(difference)
            if enter:
                self.enter()
        except (sa.exc.SQLAlchemyError, OSError, LedgerError) as error:
            self.close()
            raise (StartError if _may_pass(error) else SettingError)(
                f"the ledger {self.name} cannot be opened: {reason(error)}", field="database_url"
            ) from error
        if self.file is not None:
            self._inode = _inode(self.file)
        self.is_open = True

    def missing(self) -> str | None:
        """Why the database does not answer yet; None if it does, or with these settings never will.

        SQLite's is never missing.
        """
        if self.url.get_backend_name() == "sqlite":
            return None
        try:
            self._engine.connect().close()
        except sa.exc.OperationalError as error:
            why = reason(error)
            return None if _REFUSAL.search(why) else why
        return None

    def difference(self) -> str | None:
        """Why this is not the ledger that this server left; None if it is."""
        place = self.place()
        connection = self._connected()
        with connection.begin():
            if place is None:
                # A server that joins others has no file yet.
                what = None
                if self._beside and not self.shared and writer_store.any_epoch(connection):
                    what = f"{self._beside.path}, which belongs to it, is missing"
            elif place.log in history.former_logs(connection):
                what = None  # another server has restored the ledger since
            else:
                same = place.log == history.log_id(connection)
                commit = writer_store.last_batch(connection, place.epoch) if same else None
                what = _behind(place, commit)
        return what and f"{what}: it {self._advice()}"

    def _advice(self) -> str:
        assert self._beside is not None
        lost = "" if self.file is None else f", or lost its write-ahead log ({self.file.name}-wal)"
        return (
            f"was restored, copied or moved{lost}; put the missing file back, or run `plinko "
            "ledger restore` to continue with the ledger as it is"
        )

    def place(self) -> Place | None:
        """What the file beside the ledger says; None if there is no file."""
        return None if self._beside is None else self._beside.read()

    def enter(self, change: Callable[[Connection], None] = lambda connection: None) -> None:
        """Begin an epoch, in one transaction with `change`; see `epoch` for the order of steps."""
        self._epoch, self._reconnects, self._batch = secrets.token_hex(16), 0, 0
        connection, former = self._connected(), self.place()
        with connection.begin():
            change(connection)
            writer_store.enter(connection, self._epoch, "" if former is None else former.epoch)
            log = history.log_id(connection)
        if self._beside is not None:
            self._beside.begin(Place(log, self._epoch, 0))

    @contextlib.contextmanager
    def transaction(self) -> Iterator[Connection]:
        """A transaction: committed at the end of the block, rolled back if the block raises.

        After an error the connection is closed, because its state is unknown.
        """
        try:
            if self._inode is not None and self.file is not None:
                self._check_file(self.file)
            connection = self._connected()
            with connection.begin():
                yield connection
        except BaseException:
            self.disconnect()
            raise

    @contextlib.contextmanager
    def batch(self) -> Iterator[Connection]:
        """A numbered transaction. After InDoubtError, `has_batch` finds out if it is durable.

        After any other error it is not, and never will be, because no COMMIT was sent.
        """
        complete = False
        try:
            with self.transaction() as connection:
                writer_store.count(connection, self._epoch, self._reconnects, self._batch + 1)
                yield connection
                complete = True
            self._note(self._batch + 1)
        except Exception as error:
            if complete:
                raise InDoubtError(reason(error)) from error
            raise
        self._batch += 1

    def has_batch(self) -> bool:
        """Whether the batch in doubt is durable. The answer is final.

        The batch's transaction locked the writer's row first, so reading that row over a new
        connection waits until it has ended. Counting the connections in the same transaction makes
        every later write over the former one fail.
        """
        self.disconnect()
        with self.transaction() as connection:
            found, self._reconnects = writer_store.renew(connection, self._epoch)
        if found > self._batch:
            self._note(found)
        there, self._batch = found > self._batch, found
        return there

    def _note(self, batch: int) -> None:
        """Write the number of a durable batch beside the ledger, before anybody hears of it."""
        if self._beside is not None:
            self._beside.note(batch)

    def cut(self) -> None:
        """Shut down the connection to PostgreSQL, so that a call waiting for it fails.

        For any thread. SQLite needs none of this, because its waits are all limited.
        """
        if self._socket is None:
            return
        descriptor, inode = self._socket
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as connected:
            # Another inode: the connection was closed, and its descriptor reused.
            if os.fstat(connected.fileno()).st_ino == inode:
                connected.shutdown(socket.SHUT_RDWR)

    def compact(self) -> None:
        """Return the space of deleted rows to the file system; PostgreSQL vacuums by itself."""
        if self.file is not None:
            connection = self._connected().connection.driver_connection
            assert connection is not None
            connection.execute("VACUUM")

    def disconnect(self) -> None:
        """Close the connection; the next transaction makes a new one.

        A database in memory keeps its only connection, with which it would end.
        """
        if self._connection is None or self.in_memory:
            return
        connection, self._connection = self._connection, None
        with contextlib.suppress(sa.exc.SQLAlchemyError):
            connection.invalidate()
        with contextlib.suppress(sa.exc.SQLAlchemyError):
            connection.close()

    def close(self) -> None:
        """Close the connection, and release the locks for other servers."""
        if self._connection is not None:
            with contextlib.suppress(sa.exc.SQLAlchemyError):
                self._connection.close()
            self._connection = None
        self._engine.dispose()
        self.is_open = False
        if self._beside is not None:
            self._beside.close()
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def _connected(self) -> Connection:
        if self._connection is None:
            connection = self._engine.connect()
            try:
                # Before the lock: it would keep another server that starts from a migration.
                if not self.is_open:
                    migrate(connection)
                if self._engine.dialect.name == "postgresql":
                    self._attach(connection)
            except BaseException:
                connection.close()
                raise
            self._connection = connection
        return self._connection

    def _attach(self, connection: Connection) -> None:
        """Succeed the former connection to PostgreSQL, for as long as this one lasts.

        Servers that share the database share its lock. While this server had none, a later release
        may have changed the tables.
        """
        backend = writer_store.succeed(connection, self._backend)
        with connection.begin():
            if self.shared:
                why = "another server uses it exclusively"
                _lock_database(connection, "pg_advisory_lock_shared", why)
            else:
                _lock_database(connection, "pg_advisory_lock", "another server uses it")
            revision = connection.scalars(sa.select(tables.revision.c.version_num)).one()
            if revision > HEAD:
                self.outdated = _later(revision) if self.is_open else ""
                raise LedgerError(_later(revision))
        self._backend, self._socket = backend, _socket_of(connection)

    def _check_file(self, file: Path) -> None:
        """Raise LedgerError if the open file was replaced, OSError if it is missing.

        SQLite would continue to write into a deleted file, and all of that would be lost.
        """
        if _inode(file) != self._inode:
            raise LedgerError(f"{file} was replaced by another file; start the server again")


def _may_pass(error: Exception) -> bool:
    """Whether the ledger may open later with the same settings."""
    if isinstance(error, sa.exc.OperationalError):
        return _REFUSAL.search(reason(error)) is None
    full = isinstance(error, OSError) and error.errno in _FULL
    return full or isinstance(error, LedgerInUseError)


def _behind(place: Place, commit: int | None) -> str | None:
    """What a ledger with this last commit of the place's epoch has lost, if anything."""
    if commit is None:
        return "it lacks the start that the file of its epoch names"
    if commit < place.commit:
        return f"it has lost its last commits: it ends at {commit}, and {place.commit} were made"
    return None


def reason(error: BaseException) -> str:
    """The message of a database's error, without the statement and without any value of a row.

    PostgreSQL puts values into a message's detail, such as the whole row that violates a
    constraint, and those that it cannot read into the message itself.
    """
    if isinstance(error, sa.exc.StatementError) and error.orig is not None:
        unreadable = isinstance(error, sa.exc.DataError) or isinstance(error.orig, ValueError)
        error = error.orig
        if unreadable:
            return type(error).__name__
    diagnosis = getattr(error, "diag", None)  # of psycopg
    if diagnosis is not None and diagnosis.message_primary:
        return str(diagnosis.message_primary)
    return " ".join(str(error).split()) or type(error).__name__


def migrate(connection: Connection) -> None:
    """Make the tables, or migrate those of an earlier release to `HEAD`.

    Raises LedgerError if they are of a later release, LedgerInUseError if they must change while
    servers use them. If servers share the database, one at a time does so.
    """
    with connection.begin():
        if connection.dialect.name == "postgresql":
            # Python code may leave the transaction idle for longer than usual. Only servers that
            # start wait for it, each for as long.
            for limit in ("statement_timeout", "idle_in_transaction_session_timeout"):
                connection.execute(sa.text(f"SET LOCAL {limit} = '{_MIGRATION_SECONDS}s'"))
            connection.execute(sa.text(f"SELECT pg_advisory_xact_lock({_MIGRATION_LOCK})"))
        revision = _revision(connection)
        if revision is None:
            tables.metadata.create_all(connection, checkfirst=False)
            connection.execute(sa.insert(tables.revision).values(version_num=HEAD))
        elif revision > HEAD:
            raise LedgerError(_later(revision))
        elif revision != HEAD:
            if connection.dialect.name == "postgresql":
                why = (
                    f"another server uses it, and this release must change its tables from step "
                    f"{revision!r} to {HEAD!r}: stop all servers of the earlier release"
                )
                _lock_database(connection, "pg_advisory_xact_lock", why)
            _upgrade(connection, revision)


def _later(revision: str) -> str:
    return (
        f"its tables are at migration step {revision!r}, but this release only knows the steps up "
        f"to {HEAD!r}; use a later release"
    )


def _upgrade(connection: Connection, revision: str) -> None:
    # Alembic is imported only for a migration, because importing it slows the start.
    from alembic import command  # noqa: PLC0415
    from alembic.config import Config  # noqa: PLC0415
    from alembic.util import CommandError  # noqa: PLC0415

    config = Config()
    config.set_main_option("script_location", "plinko.app.persistence.ledger:migrations")
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, "head")
    except CommandError as error:
        raise LedgerError(
            f"its tables are at migration step {revision!r}, which this release cannot migrate: "
            f"{error}"
        ) from error


def _revision(connection: Connection) -> str | None:
    """The migration step of the tables; None if there are no tables."""
    if not sa.inspect(connection).has_table(tables.revision.name):
        return None
    found: str | None = connection.scalar(sa.select(tables.revision.c.version_num))
    return found


def reader(url: str) -> Engine:
    """A read-only engine, for a process other than the server that writes."""
    parsed = address(url)
    if parsed.get_backend_name() != "sqlite":
        return _postgres(parsed, shared=False).execution_options(postgresql_readonly=True)
    file = f"file:{quote(str(parsed.database))}?mode=rw"  # "rw" does not create a missing file

    def connect() -> sqlite3.Connection:
        connection = sqlite3.connect(file, timeout=_ANSWER_SECONDS, uri=True)
        connection.execute("PRAGMA query_only = ON")
        return connection

    return sa.create_engine("sqlite://", creator=connect, poolclass=NullPool)


def _sqlite(url: URL) -> Engine:
    in_memory = url.database in (None, ":memory:")
    engine = sa.create_engine(
        url,
        hide_parameters=True,
        poolclass=StaticPool if in_memory else NullPool,
        connect_args={"check_same_thread": False, "timeout": _ANSWER_SECONDS},
    )

    @event.listens_for(engine, "connect")
    def _prepare(connection: sqlite3.Connection, _: object) -> None:
        # Python's driver begins transactions implicitly, and leaves statements that create tables
        # outside. Turn that off; `_begin` sends BEGIN.
        connection.isolation_level = None
        connection.execute("PRAGMA journal_mode = WAL")
        # A commit returns only after its data is on the disk.
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA foreign_keys = ON")
        # Truncate a write-ahead log that a long read, such as a backup, has let grow.
        connection.execute(f"PRAGMA journal_size_limit = {_LOG_BYTES}")
        # 512 kB are enough: rows are appended to the tables, and rarely read.
        connection.execute("PRAGMA cache_size = -512")

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")

    return engine


def _postgres(url: URL, *, shared: bool) -> Engine:
    options = f"-c synchronous_commit=on -c statement_timeout={1000 * _ANSWER_SECONDS}"
    if shared:
        # End the transaction of a frozen server, so that others can take its rooms.
        options += f" -c idle_in_transaction_session_timeout={1000 * _IDLE_SECONDS}"
    try:
        return sa.create_engine(
            url,
            hide_parameters=True,
            poolclass=NullPool,
            connect_args={
                "connect_timeout": _ANSWER_SECONDS,
                "keepalives_idle": 2 * _ANSWER_SECONDS,
                "tcp_user_timeout": 1000 * _ANSWER_SECONDS,
                "options": options,
                "application_name": "plinko",
            },
        )
    except (ImportError, NoSuchModuleError):
        raise SettingError(
            "PostgreSQL needs its driver: pip install 'plinko-sim[postgres]'",
            field="database_url",
        ) from None


def _socket_of(connection: Connection) -> tuple[int, int]:
    """The descriptor and inode of a PostgreSQL connection's socket."""
    driver = connection.connection.driver_connection
    assert driver is not None
    descriptor = driver.fileno()
    return descriptor, os.fstat(descriptor).st_ino


def _lock_database(connection: Connection, how: str, why: str) -> None:
    """Take PostgreSQL's advisory lock by the function `how`, in a transaction.

    Waits up to a second, because PostgreSQL may not have noticed yet that the former server has
    ended; then raises LedgerInUseError with `why`.
    """
    try:
        connection.execute(sa.text(f"SET LOCAL lock_timeout = '{_LOCK_SECONDS}s'"))
        connection.execute(sa.text(f"SELECT {how}({_LOCK})"))
        connection.execute(sa.text("SET LOCAL lock_timeout = 0"))
    except sa.exc.OperationalError as error:
        if getattr(error.orig, "sqlstate", None) != _LOCK_NOT_AVAILABLE:
            raise
        raise LedgerInUseError(why) from None


def _lock_file(file: Path) -> int:
    """Lock FILE-lock next to SQLite's file until the process ends; raises LedgerInUseError.

    A lock on the database file itself would be wrong: closing its descriptor would release SQLite's
    locks too.
    """
    descriptor = os.open(f"{file}-lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise LedgerInUseError(
            "another server uses it; give this one a --data directory or --database-url that no "
            "other server uses"
        ) from None
    return descriptor


def _make_private(file: Path) -> None:
    """Create SQLite's file if it is missing, and let only its owner read and write it.

    SQLite gives its further files the same mode.
    """
    os.close(os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600))
    for each in (file, Path(f"{file}-wal"), Path(f"{file}-shm")):
        # The file may be missing, or belong to another user that lets this one write.
        with contextlib.suppress(FileNotFoundError, PermissionError):
            each.chmod(0o600)


def _check_one_name(file: Path) -> None:
    """Raise LedgerError if the file has hard links.

    Under another name of the file SQLite would use another write-ahead log, and commits in the
    first log would be lost. Symbolic links are harmless, because they are followed.
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
