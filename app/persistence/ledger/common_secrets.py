"""The signing secrets of servers that share a ledger: the first server stores them in it."""

import secrets
from typing import Final

from sqlalchemy import Connection, delete, insert, select

from plinko.app.errors import SettingError
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.statements import tables

_BYTES: Final = 32

TOKENS: Final = "tokens"
"""Name of the secret that signs the tokens of rooms and fair sessions."""

STATEMENTS: Final = "statements"
"""Name of the secret that signs receipts and fair sessions."""


def common_secret(database: Database, name: str) -> bytes:
    """The secret `name`, 32 bytes, created if it is missing; opens the database if need be.

    Raises SettingError if the database cannot be opened or the stored secret is invalid.
    """
    if not database.is_open:
        database.open()
    with database.transaction() as connection:
        made = {"name": name, "value": secrets.token_hex(_BYTES)}
        connection.execute(tables.adding(connection, tables.secrets).on_conflict_do_nothing(), made)
        found = read(connection, name)
    assert found is not None
    return found


def read(connection: Connection, name: str) -> bytes | None:
    """The secret `name`, if it exists; raises SettingError if it is invalid."""
    chosen = select(tables.secrets.c.value).where(tables.secrets.c.name == name)
    text: str | None = connection.scalar(chosen)
    if text is None:
        return None
    try:
        secret = bytes.fromhex(text)
    except ValueError:
        secret = b""
    if len(secret) != _BYTES:
        raise SettingError(
            f"the secret {name!r} in the ledger is not {2 * _BYTES} hexadecimal digits",
            field="database_url",
        )
    return secret


def replace(connection: Connection, name: str, secret: bytes) -> None:
    """Make `secret` the one of this name."""
    connection.execute(delete(tables.secrets).where(tables.secrets.c.name == name))
    connection.execute(insert(tables.secrets).values(name=name, value=secret.hex()))
