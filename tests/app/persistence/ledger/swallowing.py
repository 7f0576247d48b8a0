"""Swallow the answer to a COMMIT between the database and the server."""

import contextlib
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from plinko.app.persistence.ledger.database import Database
from tests.app.persistence.ledger.stepped import failure

_SOCKET = ".s.PGSQL.5432"
_COMMIT = b"COMMIT\0"


class Swallower:
    """Loses the answer to a COMMIT of writes, not of a transaction that only reads."""

    def __init__(self, database: Database) -> None:
        self.swallowed = 0
        self._armed = ""
        self._batch = database.batch
        database.batch = self._aimed  # type: ignore[method-assign]

    def arm(self, *, cut: bool) -> None:
        """Swallow the next answer. `cut` closes the connection, too; otherwise it stays silent."""
        self._armed = "cut" if cut else "silence"

    @contextlib.contextmanager
    def _aimed(self) -> Iterator[Any]:
        with self._batch() as connection:
            yield connection
            order, self._armed = self._armed, ""
            if order:
                self.swallow(order)
                self.swallowed += 1

    def swallow(self, order: str) -> None:
        """Swallow the answer to the COMMIT that comes now."""
        raise NotImplementedError


class SQLiteSwallower(Swallower):
    """SQLite has no connection to cut: the swallower raises an error after the commit."""

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._fails = False
        self._transaction = database.transaction
        database.transaction = self._wrapped  # type: ignore[method-assign]

    def swallow(self, order: str) -> None:
        self._fails = True

    @contextlib.contextmanager
    def _wrapped(self) -> Iterator[Any]:
        with self._transaction() as connection:
            yield connection
        if self._fails:
            self._fails = False
            raise failure()


class LineSwallower(Swallower):
    """PostgreSQL behind a proxy, which forwards the COMMIT but not its answer."""

    def __init__(self, database: Database, proxy: "Proxy") -> None:
        super().__init__(database)
        self._proxy = proxy

    def swallow(self, order: str) -> None:
        self._proxy.order = order


class Proxy:
    """A proxy of PostgreSQL, with its socket in `folder`."""

    def __init__(self, folder: Path, real: Path) -> None:
        self.order = ""
        self._real = str(real / _SOCKET)
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(folder / _SOCKET))
        self._listener.listen()
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                server = socket.socket(socket.AF_UNIX)
                server.connect(self._real)
                threading.Thread(target=_Line(self, client, server).run, daemon=True).start()


class _Line:
    def __init__(self, proxy: Proxy, client: socket.socket, server: socket.socket) -> None:
        self._proxy = proxy
        self._client = client
        self._server = server
        self._order = ""

    def run(self) -> None:
        with self._client, self._server:
            answering = threading.Thread(target=self._answer, daemon=True)
            answering.start()
            self._ask()
            answering.join()

    def _ask(self) -> None:
        with contextlib.suppress(OSError):
            while data := self._client.recv(1 << 16):
                if data.endswith(_COMMIT):
                    self._order, self._proxy.order = self._proxy.order, ""
                self._server.sendall(data)
        self._end()

    def _answer(self) -> None:
        with contextlib.suppress(OSError):
            while data := self._server.recv(1 << 16):
                if not self._order:
                    self._client.sendall(data)
                elif self._order == "cut":
                    break
        if self._order != "silence":
            self._end()

    def _end(self) -> None:
        for each in (self._client, self._server):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def proxied(url: str, folder: Path) -> Iterator[tuple[str, Proxy]]:
    """Run a proxy; gives PostgreSQL's address through it, and the proxy."""
    plain, _, real = url.partition("?host=")
    place = folder / "line"
    place.mkdir()
    proxy = Proxy(place, Path(os.fspath(real)))
    try:
        yield f"{plain}?host={place}", proxy
    finally:
        proxy.close()
