"""Reading a ledger of which some pages may be damaged, and what can be had of its list of rooms."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeVar

import sqlalchemy as sa
from sqlalchemy import Connection

from app.errors import DamagedRoomError
from app.persistence.ledger.null_ledger import NullLedger
from app.persistence.ledger.writer import Ledger
from app.persistence.statements import store
from app.rooms.records import RoomRow

T = TypeVar("T")

_UNREADABLE: Final = 1_000_000
"""By how much runs are numbered on from the highest that can be read, where some cannot."""


@dataclass(frozen=True, slots=True)
class Salvaged:
    """What is left of a damaged list of rooms: open runs, the longest unused first.

    `lost` runs cannot be read, open or closed; new ones are numbered from `next_number` on.
    """

    rows: list[RoomRow]
    lost: int
    next_number: int


async def read_sound(ledger: Ledger | NullLedger, read: Callable[..., T], **values: object) -> T:
    """What `read` finds, where the pages that hold it are whole; else raises DamagedRoomError.

    Raises LedgerError when the ledger cannot be read at all.
    """
    return await ledger.read(_sound, read, **values)


async def salvage(ledger: Ledger | NullLedger) -> Salvaged:
    """Every open run that can be read by itself; raises LedgerError."""
    highest = 0
    for read in (store.last_number, store.last_number_of_drops, store.last_number_of_inputs):
        with contextlib.suppress(DamagedRoomError):
            highest = max(highest, await read_sound(ledger, read))
    rows: list[RoomRow] = []
    lost = 0
    for number in range(1, highest + 1):
        try:
            row = await read_sound(ledger, store.open_run, number=number)
        except DamagedRoomError:
            lost += 1
        else:
            rows += [] if row is None else [row]
    rows.sort(key=lambda row: row.used)
    return Salvaged(rows, lost, highest + _UNREADABLE)


def _sound(connection: Connection, read: Callable[..., T], /, **values: object) -> T:
    try:
        return read(connection, **values)
    except sa.exc.DatabaseError as error:
        # Its subclasses are what happens to a sound database, too.
        if type(error) is not sa.exc.DatabaseError:
            raise
        raise DamagedRoomError("the database's pages that hold it are damaged") from error
