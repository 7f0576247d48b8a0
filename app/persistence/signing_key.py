"""The key that signs the ledger's statements: whether it is the right one, and its change.

The ledger has all public keys that its statements were signed with, each change signed by both
keys. The private key is in a file, or in the table `secrets` if servers share the ledger or have no
data directory.
"""

import os
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec
from sqlalchemy import Connection

from plinko.app.errors import SettingError
from plinko.app.fairness.signing import Signer, is_signed
from plinko.app.fairness.statements import KeyStatement
from plinko.app.persistence.ledger import common_secrets
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.ledger.epoch import sync_names
from plinko.app.persistence.restoring import end_sessions
from plinko.app.persistence.statements import fair_store, history, lease_store, store
from plinko.app.rooms.canonical import canonical

_BYTES: Final = 32


def secret_file(database: Database, directory: Path | None) -> Path | None:
    """The file of the secret that signs tokens: next to SQLite's file, else in the data directory.

    None for a ledger in memory: its rooms end with the process, so their tokens may end too.
    """
    if database.in_memory:
        return None
    file = database.file
    return file.with_name(f"{file.name}-secret") if file else directory and directory / "secret"


class SigningKey:
    """The key of this ledger, known after `settle`; all calls block.

    directory: the server's data directory, if it has one.
    """

    def __init__(self, database: Database, directory: Path | None) -> None:
        self._database = database
        file = secret_file(database, directory)
        self._file = file and file.with_name(f"{file.name}-signing-key")
        self._signer: Signer | None = None

    @property
    def signer(self) -> Signer:
        assert self._signer is not None, "the ledger is not open"
        return self._signer

    def settle(self, now: float) -> None:
        """Find the key, or make one for a ledger that has signed nothing. `now`: Unix time, s.

        Raises SettingError if the ledger's statements were signed with another key.
        """
        if self._signer is not None:
            return
        with self._database.transaction() as connection:
            if self._database.shared:
                lease_store.wait_for_log(connection)  # only one of several servers makes a key
            place = self._place(connection)
            found = place.read(connection)
            secret = found or secrets.token_bytes(_BYTES)
            signer = Signer(secret)
            self._check(connection, place, signer, now, missing=found is None)
            if found is None:
                place.write(connection, secret)
        self._signer = signer

    def change(self, now: float, *, lost: bool = False) -> tuple[str, int]:
        """Make another key the ledger's; returns it, and the number of sessions that this ended.

        A session has one key, so open ones end. lost: the former key is not needed. Raises
        SettingError. After a crash, call it again.
        """
        with self._database.transaction() as connection:
            place = self._place(connection)
            known = history.keys(connection, history.STATEMENTS)
            draft = place.draft()
            if draft is not None and known and Signer(draft).public.hex() == known[-1].value:
                place.adopt()
                return known[-1].value, 0
            former = None if lost else place.read(connection)
            if not lost:
                old = Signer(former or secrets.token_bytes(_BYTES))
                self._check(connection, place, old, now, missing=former is None)
                known = history.keys(connection, history.STATEMENTS)
            secret = secrets.token_bytes(_BYTES)
            signer = Signer(secret)
            ended = end_sessions(connection, Signer(former) if former else signer, now)
            _add(connection, known, signer, now, Signer(former) if former else None)
            place.prepare(connection, secret)
        place.adopt()
        return signer.public.hex(), ended

    def _place(self, connection: Connection) -> "_Row | _File":
        row = _Row()
        if self._file is None or self._database.shared or row.read(connection) is not None:
            return row
        return _File(self._file)

    def _check(
        self,
        connection: Connection,
        place: "_Row | _File",
        signer: Signer,
        now: float,
        *,
        missing: bool,
    ) -> None:
        """Raise SettingError unless the ledger's statements were signed with this key.

        Notes the key of a ledger that knows none.
        """
        known, public = history.keys(connection, history.STATEMENTS), signer.public
        if known and known[-1].value == public.hex():
            return
        newest = fair_store.newest_signed(connection)
        if newest is None:
            history.forget_keys(connection, history.STATEMENTS)
            _add(connection, [], signer, now, None)
            return
        statement, signature = newest
        values = msgspec.json.decode(statement)
        if not known and is_signed(values, bytes.fromhex(signature), public):
            _add(connection, [], signer, now, None)
            return
        draft = place.draft()
        if draft is not None and known and Signer(draft).public.hex() == known[-1].value:
            raise SettingError(
                f"the change to the key in {place.name}-new was interrupted; run `plinko ledger "
                "rotate-key` to finish it",
                field="data",
            )
        raise SettingError(
            f"{place.name} {'is missing' if missing else 'has another key'}: it must have the key "
            "that signed this ledger's sessions and receipts; restore it from the backup that has "
            "this ledger, or, if no copy is left, run `plinko ledger rotate-key --lost`",
            field="data",
        )


class _File:
    """A private key in a file, as hexadecimal digits that only its owner may read."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._draft = file.with_name(f"{file.name}-new")
        self.name = str(file)

    def read(self, connection: Connection) -> bytes | None:
        return _read(self._file)

    def write(self, connection: Connection, secret: bytes) -> None:
        self.prepare(connection, secret)
        self.adopt()

    def draft(self) -> bytes | None:
        return _read(self._draft)

    def prepare(self, connection: Connection, secret: bytes) -> None:
        """Write the next key beside the present one, before the ledger knows it."""
        self._file.parent.mkdir(0o700, parents=True, exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC
        with os.fdopen(os.open(self._draft, flags, 0o600), "w") as out:
            out.write(secret.hex() + "\n")
            out.flush()
            os.fsync(out.fileno())

    def adopt(self) -> None:
        """Replace the present key by the next one."""
        os.replace(self._draft, self._file)
        sync_names(self._file.parent)


class _Row:
    """A private key in the ledger itself, for servers without a common file."""

    name = f"the row {common_secrets.STATEMENTS!r} of the table `secrets`"

    def read(self, connection: Connection) -> bytes | None:
        return common_secrets.read(connection, common_secrets.STATEMENTS)

    def write(self, connection: Connection, secret: bytes) -> None:
        self.prepare(connection, secret)

    def draft(self) -> bytes | None:
        return None

    def prepare(self, connection: Connection, secret: bytes) -> None:
        common_secrets.replace(connection, common_secrets.STATEMENTS, secret)

    def adopt(self) -> None:
        """Nothing is left to do: the row is replaced in the transaction."""


def _add(
    connection: Connection,
    known: list[history.KeyRow],
    signer: Signer,
    now: float,
    former: Signer | None,
) -> None:
    """Note a key, with a statement if there was one before; `former` signs too, unless lost."""
    statement = signature = former_signature = None
    if known:
        values = KeyStatement(signer.public.hex(), known[-1].value, int(now * 1000.0)).to_dict()
        statement, signature = canonical(values).decode(), signer.sign(values).hex()
        former_signature = None if former is None else former.sign(values).hex()
    history.add_key(
        connection,
        history.KeyRow(
            history.next_key(connection), history.STATEMENTS, signer.public.hex(), now,
            statement, signature, former_signature,
        ),
    )  # fmt: skip


def _read(file: Path) -> bytes | None:
    """The key in a file; None if the file is missing. Raises SettingError."""
    try:
        text = file.read_text(encoding="ascii").strip()
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise SettingError(f"cannot read the key in {file}: {error}", field="data") from error
    try:
        key = bytes.fromhex(text)
    except ValueError:
        key = b""
    if len(key) != _BYTES:
        raise SettingError(
            f"the key in {file} is not {2 * _BYTES} hexadecimal digits; restore it from a backup, "
            "because signatures made with the key can be checked only against it",
            field="data",
        )
    return key


# The secret that signs tokens.


@dataclass(frozen=True, slots=True)
class Orphans:
    """Open rooms and sessions whose tokens were signed with another secret."""

    rooms: int
    sessions: int


def orphans(database: Database, mark: str, now: float) -> Orphans:
    """Note the secret of tokens by its `mark`, and count what has tokens of other secrets.

    A mark is 64 hexadecimal digits that do not reveal the secret. The ledger has the time from
    which each secret was used; the first one counts from the beginning.
    """
    with database.transaction() as connection:
        if database.shared:
            lease_store.wait_for_log(connection)  # only one of several servers notes a secret
        known = history.keys(connection, history.TOKENS)
        if not known or known[-1].value != mark:
            since = now if known else 0.0
            row = history.KeyRow(history.next_key(connection), history.TOKENS, mark, since)
            history.add_key(connection, row)
            known.append(row)
        ends = [row.since for row in known[1:]]
        others = [(row.since, end) for row, end in zip(known, ends, strict=False)
                  if row.value != mark]  # fmt: skip
        return Orphans(
            sum(store.owned_since(connection, *each) for each in others),
            sum(fair_store.unended_since(connection, *each) for each in others),
        )
