"""The statements that read rooms, inputs and results, queues, shows and orders."""

from collections.abc import Sequence
from typing import Any, Final

import msgspec
from sqlalchemy import ColumnElement, Connection, func, select

from plinko.app.errors import DamagedRoomError, PrunedError
from plinko.app.fairness.statements import Receipt
from plinko.app.persistence.statements import tables
from plinko.app.protocol.messages import SignedReceipt
from plinko.app.rooms.queue import EMPTY, Queue
from plinko.app.rooms.records import (
    LOG_LEAVES,
    DropRow,
    InputRow,
    ListedRoom,
    Order,
    ResultRow,
    RoomRow,
    ShowRow,
    StoredBasis,
    TakenRow,
)
from plinko.engine.errors import shorten


def open_room(connection: Connection, room_id: str) -> RoomRow | None:
    return _latest(connection, tables.rooms.c.id == room_id, tables.rooms.c.closed.is_(None))


def closed_room(connection: Connection, room_id: str) -> RoomRow | None:
    """The last closed run of the room `room_id`."""
    return _latest(connection, tables.rooms.c.id == room_id, tables.rooms.c.closed.is_not(None))


def _latest(connection: Connection, *conditions: ColumnElement[bool]) -> RoomRow | None:
    """The latest run that meets these conditions."""
    chosen = select(tables.rooms).where(*conditions).order_by(tables.rooms.c.number.desc())
    found = connection.execute(chosen.limit(1)).mappings().first()
    return None if found is None else RoomRow(**found)


def awake_rooms(connection: Connection) -> list[str]:
    """The ids of rooms that were awake at their last mark, the latest used first."""
    room = tables.rooms.c
    chosen = select(room.id).where(room.closed.is_(None), room.awake).order_by(room.used.desc())
    return list(connection.execute(chosen).scalars())


def directory(connection: Connection) -> list[ListedRoom]:
    """All open runs."""
    return [ListedRoom(*row) for row in connection.execute(_CHOSEN)]


def unused_rooms(connection: Connection, before: float, limit: int) -> list[ListedRoom]:
    """At most `limit` sleeping rooms with owners that were last used before a Unix time, in s."""
    room = tables.rooms.c
    chosen = _CHOSEN.where(room.awake.is_(False), room.owned, room.used < before)
    rows = connection.execute(chosen.order_by(room.used).limit(limit))
    return [ListedRoom(*row) for row in rows]


_CHOSEN: Final = (
    select(
        tables.rooms.c.number,
        tables.rooms.c.id,
        tables.boards.c.name,
        tables.rooms.c.board,
        tables.rooms.c.mode,
        tables.rooms.c.tick,
        tables.rooms.c.checkpoint_drops,
        tables.rooms.c.used,
        tables.rooms.c.awake,
    )
    .outerjoin_from(tables.rooms, tables.boards)
    .where(tables.rooms.c.closed.is_(None))
)
"""The columns of `ListedRoom`, of open runs."""


def count_owned(connection: Connection, creator: str | None = None) -> int:
    """The number of open rooms with owners, of all or with this creator's mark."""
    room = tables.rooms.c
    chosen = select(func.count()).where(room.closed.is_(None), room.owned)
    if creator is not None:
        chosen = chosen.where(room.creator == creator)
    return int(connection.scalar(chosen) or 0)


def owned_since(connection: Connection, begin: float, end: float) -> int:
    """The number of open rooms with owners whose runs began between two Unix times, in s."""
    room = tables.rooms.c
    chosen = select(func.count()).where(room.closed.is_(None), room.owned)
    return int(connection.scalar(chosen.where(room.opened >= begin, room.opened < end)) or 0)


def last_number(connection: Connection) -> int:
    """The highest number of a run, or 0."""
    return int(connection.scalar(select(func.max(tables.rooms.c.number))) or 0)


def open_run(connection: Connection, number: int) -> RoomRow | None:
    return _latest(connection, tables.rooms.c.number == number, tables.rooms.c.closed.is_(None))


def board(connection: Connection, digest: str) -> str | None:
    found = select(tables.boards.c.json).where(tables.boards.c.digest == digest)
    text: str | None = connection.execute(found).scalar()
    return text


def basis(connection: Connection, board_digest: str, draw_digest: str | None) -> StoredBasis:
    """A board and, if any, a draw, each as JSON."""
    draw = select(tables.draws.c.json).where(tables.draws.c.digest == draw_digest)
    return StoredBasis(board(connection, board_digest), connection.scalar(draw))


FACTS: Final = select(
    *(
        tables.players.c.who if column is tables.drops.c.player else column
        for column in tables.drops.c
    )
).outerjoin_from(tables.drops, tables.players)
"""The columns of `DropRow`."""


def drops(
    connection: Connection, room: int, first: int, limit: int | None = None
) -> list[tuple[DropRow, ResultRow | None]]:
    """Drops of a run from ball number `first` on, in order, each with its result if it has one.

    Raises PrunedError if they were deleted after the time for which the server keeps drops, and
    DamagedRoomError if a number is missing or a seed is invalid.
    """
    drop, result = tables.drops.c, tables.results.c
    chosen = (
        FACTS.add_columns(*result)  # in the order of the rows' fields
        .outerjoin(tables.results)
        .where(drop.room == room, drop.ball >= first)
        .order_by(drop.ball)
        .limit(limit)
    )
    fields = len(FACTS.selected_columns)
    rows = connection.execute(chosen)
    found = [(drop_of(*row[:fields]), result_of(row[fields:])) for row in rows]
    if not found:
        _check_pruned(connection, room, first)
    for number, (row, _) in enumerate(found, first):
        if row.ball != number:
            _check_pruned(connection, room, number)
            raise DamagedRoomError(f"run {room} of the ledger lacks drop {number}")
    return found


def _check_pruned(connection: Connection, run: int, number: int) -> None:
    pruned = connection.scalar(select(tables.rooms.c.pruned).where(tables.rooms.c.number == run))
    if pruned is not None and number < pruned:
        raise PrunedError(
            f"the server has deleted the old drops of this room, up to number {pruned - 1}; "
            f"request those from {pruned} on (first={pruned})",
            field="first",
        )


def drop(
    connection: Connection, run: int, ball: int
) -> tuple[DropRow, SignedReceipt | None, ResultRow | None]:
    """A drop of a run, its receipt and its result, if it has them; raises DamagedRoomError."""
    found = drops(connection, run, ball, 1)
    if not found:
        raise DamagedRoomError(f"run {run} of the ledger lacks drop {ball}")
    ((row, result),) = found
    receipt = tables.receipts.c
    chosen = RECEIPTS.where(receipt.room == run, receipt.ball == ball)
    signed: Sequence[Any] | None = connection.execute(chosen).first()
    return row, None if signed is None else receipt_of(*signed), result


RECEIPTS: Final = (
    select(
        *tables.receipts.c,
        tables.drops.c.stake,
        tables.drops.c.aim,
        tables.drops.c.seed,
        tables.fair_sessions.c.board,
        tables.fair_sessions.c.room,
    )
    .join(
        tables.drops,
        (tables.drops.c.room == tables.receipts.c.room)
        & (tables.drops.c.ball == tables.receipts.c.ball),
    )
    .join(tables.fair_sessions, tables.fair_sessions.c.id == tables.receipts.c.session)
)
"""Receipts with the columns of their drops and sessions that make their JSON."""


def receipt_of(
    leaf: int,
    session: str,
    number: int,
    run: int,
    ball: int,
    time: int,
    root: str,
    signature: str,
    stake: int,
    aim: float | None,
    seed: int,
    board: str,
    room: str,
) -> SignedReceipt:
    """The receipt in these columns, which are those of RECEIPTS."""
    receipt = Receipt(session, number, stake, aim, str(seed), board, room, ball, time)
    return SignedReceipt(receipt.to_dict(), leaf % LOG_LEAVES, root, signature)


def run_numbers(connection: Connection, room_ids: Sequence[str] = ()) -> list[int]:
    """The numbers of all runs, or of those of these rooms, in order."""
    number, chosen = tables.rooms.c.number, select(tables.rooms.c.number)
    if room_ids:
        chosen = chosen.where(tables.rooms.c.id.in_(room_ids))
    return list(connection.execute(chosen.order_by(number)).scalars())


def run(connection: Connection, number: int) -> RoomRow:
    row = _latest(connection, tables.rooms.c.number == number)
    assert row is not None
    return row


def unended_drops(connection: Connection, room: int) -> list[tuple[int, int]]:
    """The ball and the stake of each drop of a run that has no result, in order."""
    drop, result = tables.drops.c, tables.results.c
    chosen = (
        select(drop.ball, drop.stake)
        .outerjoin(tables.results)
        .where(drop.room == room, result.ball.is_(None))
        .order_by(drop.ball)
    )
    return [(row.ball, row.stake) for row in connection.execute(chosen)]


def inputs(
    connection: Connection, room: int, first: int, limit: int | None = None
) -> list[InputRow]:
    """Inputs of a run from number `first` on, in order; raises DamagedRoomError for a gap."""
    row = tables.inputs.c
    chosen = (
        select(tables.inputs)
        .where(row.room == room, row.number >= first)
        .order_by(row.number)
        .limit(limit)
    )
    found = [InputRow(**each) for each in connection.execute(chosen).mappings()]
    for number, each in enumerate(found, first):
        if each.number != number:
            raise DamagedRoomError(f"run {room} of the ledger lacks input {number}")
    return found


def stored_inputs(
    connection: Connection, name: str, room: int, first: int, limit: int | None = None
) -> list[tuple[TakenRow, ResultRow | None]]:
    """As `drops` or `inputs`, which `name` selects; inputs have no result."""
    if name == tables.drops.name:
        return [*drops(connection, room, first, limit)]
    return [(row, None) for row in inputs(connection, room, first, limit)]


# Queues, shows and orders.


def queue(connection: Connection, room: int) -> Queue:
    """The queue of run number `room`."""
    text = connection.scalar(select(tables.queues.c.data).where(tables.queues.c.room == room))
    return EMPTY if text is None else msgspec.json.decode(text, type=Queue)


def rooms_with_queues(connection: Connection) -> list[str]:
    """The ids of open rooms with a queue that is neither empty nor paused."""
    chosen = (
        select(tables.rooms.c.id, tables.queues.c.data)
        .join(tables.rooms)
        .where(tables.rooms.c.closed.is_(None))
    )
    rows = connection.execute(chosen)
    found = ((room, msgspec.json.decode(data, type=Queue)) for room, data in rows)
    return [room for room, each in found if each.items and not each.paused]


def show(connection: Connection, room: str) -> ShowRow | None:
    found = connection.execute(select(tables.shows).where(tables.shows.c.room == room)).mappings()
    return next((ShowRow(**row) for row in found), None)


def orders(connection: Connection, after: int = 0) -> list[Order]:
    """The operator's orders with a number above `after`, the first one first."""
    row = tables.operator_actions.c
    chosen = select(tables.operator_actions).where(row.number > after).order_by(row.number)
    return [Order(**found) for found in connection.execute(chosen).mappings()]


# Rows.


def drop_of(room: int, ball: int, tick: int, seed: object, *rest: Any) -> DropRow:
    """The drop in these columns; raises DamagedRoomError."""
    if not isinstance(seed, int):
        raise DamagedRoomError(f"drop {ball} of run {room} has an invalid seed {shorten(seed)}")
    return DropRow(room, ball, tick, seed, *rest)


def result_of(fields: Sequence[Any]) -> ResultRow | None:
    """The result in these columns of an outer join; None if they are NULL."""
    return None if fields[0] is None else ResultRow(*fields)
