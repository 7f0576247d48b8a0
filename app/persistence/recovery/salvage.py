"""Reads a ledger with damaged pages, and saves the readable part of its list of rooms."""

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
"""New runs get numbers this far above the highest readable one, as lost runs may be higher."""


@dataclass(frozen=True, slots=True)
class Salvaged:
    """The readable part of a damaged list of rooms: open runs, the longest unused first.

    `lost` is the number of unreadable runs, open or closed. New runs get numbers from
    `next_number` on.
    """

    rows: list[RoomRow]
    lost: int
    next_number: int


async def read_sound(ledger: Ledger | NullLedger, read: Callable[..., T], **values: object) -> T:
    """Call `read`; raises DamagedRoomError if it meets damaged pages.

    Raises LedgerError if the ledger cannot be read at all.
    """
    return await ledger.read(_sound, read, **values)


async def salvage(ledger: Ledger | NullLedger) -> Salvaged:
    """Read every open run one by one, and count those that are lost; raises LedgerError."""
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
        # Only DatabaseError itself means damage: its subclasses also occur in a sound database.
        if type(error) is not sa.exc.DatabaseError:
            raise
        raise DamagedRoomError("its pages in the database are damaged") from error
