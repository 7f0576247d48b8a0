"""What servers that share a ledger sign with: made by the first of them, and kept in the ledger."""

import secrets
from typing import Final

from sqlalchemy import Connection, select

from app.errors import SettingError
from app.persistence.ledger.database import Database
from app.persistence.statements import tables

_BYTES: Final = 32

TOKENS: Final = "tokens"
"""What rooms' and sessions' tokens are signed with."""

STATEMENTS: Final = "statements"
"""What receipts and sessions are signed with."""


def common_secret(database: Database, name: str) -> bytes:
    """The secret of this name, 32 bytes; opens the database. Raises SettingError."""
    if not database.is_open:
        database.open()
    with database.transaction() as connection:
        found = _made_once(connection, name)
    try:
        secret = bytes.fromhex(found)
    except ValueError:
        secret = b""
    if len(secret) != _BYTES:
        raise SettingError(
            f"the secret {name!r} in {database.name} is not {2 * _BYTES} hexadecimal digits",
            field="database_url",
        )
    return secret


def _made_once(connection: Connection, name: str) -> str:
    made = {"name": name, "value": secrets.token_hex(_BYTES)}
    connection.execute(tables.adding(connection, tables.secrets).on_conflict_do_nothing(), made)
    chosen = select(tables.secrets.c.value).where(tables.secrets.c.name == name)
    value: str = connection.execute(chosen).scalar_one()
    return value
