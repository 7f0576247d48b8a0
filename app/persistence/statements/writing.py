"""The statements that write: applies values to the database in their order.

Servers that share a ledger lock its rows in one order, so that they cannot deadlock: leases of
rooms, the log of receipts, idempotency keys, boards and draws, rows of one room, sums over all
rooms.
"""

import functools
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from itertools import groupby
from operator import itemgetter
from typing import Any, Final

import sqlalchemy as sa
from sqlalchemy import Connection, Row, bindparam, delete, insert, update

from plinko.app.persistence.statements import (
    facts,
    fair_store,
    retention,
    tables,
    totals,
    webhook_store,
)
from plinko.app.persistence.statements.store import unended_drops
from plinko.app.rooms.records import (
    BoardRow,
    Close,
    DrawRow,
    Erase,
    FairEnd,
    FairOpening,
    FairSessionRow,
    Mark,
    NewDrop,
    NewInput,
    Order,
    Prune,
    QueueRow,
    Received,
    ResultRow,
    RoomRow,
    ShowRow,
    Void,
    Write,
)

_PROBE: Final = b"\0" * 8192  # more than a page, so that a database that cannot grow refuses it

_MARKED: Final = ("tick", "awake", "used")
_CHECKED: Final = (*_MARKED, "checkpoint", "checkpoint_drops")

_CONTENTS: Final = {BoardRow: tables.boards, DrawRow: tables.draws}
"""Rows that are stored once, under the digest of their content."""

Ended = Sequence[Row[Any]]
"""Room, ball and bin of each result that was not in the ledger before."""


def apply(connection: Connection, writes: Sequence[Write], targets: Sequence[str] = ()) -> None:
    """Apply `writes` in order; consecutive ones of a kind share statements.

    targets: of webhooks, which receive what happens in new runs.
    """
    # Boards and draws refer to no other rows, so they can be first.
    for kind, table in _CONTENTS.items():
        rows = [asdict(write) for write in writes if isinstance(write, kind)]
        if rows:
            adding = tables.adding(connection, table).on_conflict_do_nothing()
            connection.execute(adding, sorted(rows, key=itemgetter("digest")))
    writes = [write for write in writes if not isinstance(write, tuple(_CONTENTS))]
    ended = _write(connection, writes)
    if ended:
        _tally(connection, ended)
        totals.count(connection, [(row.room, row.ball) for row in ended])
    if targets:
        begun = [write for write in writes if isinstance(write, RoomRow)]
        webhook_store.begin(connection, targets, begun)


def _write(connection: Connection, writes: Iterable[Write]) -> Ended:
    ended: list[Row[Any]] = []
    for kind, run in groupby(writes, key=type):
        ended += _APPLY[kind](connection, list(run)) or ()
    return ended


def probe(connection: Connection) -> None:
    """Write and delete more than a page of data, to test whether the database can grow."""
    connection.execute(insert(tables.probes).values(number=1, filler=_PROBE))
    connection.execute(delete(tables.probes))


def _add_rooms(connection: Connection, rows: list[RoomRow]) -> None:
    connection.execute(insert(tables.rooms), [asdict(row) for row in rows])


def _add_results(connection: Connection, rows: list[ResultRow]) -> Ended:
    # A result may be written again, after a rebuild. It follows from the drop, so it is the same.
    result = tables.results.c
    adding = tables.adding(connection, tables.results).on_conflict_do_nothing()
    new = adding.returning(result.room, result.ball, result.bin)
    return connection.execute(new, [asdict(row) for row in rows]).all()


def _tally(connection: Connection, ended: Ended) -> None:
    """Count new results by run and bin."""
    counts = Counter((row.room, -1 if row.bin is None else row.bin) for row in ended)
    rows = [{"room": run, "bin": bin_, "results": n} for (run, bin_), n in sorted(counts.items())]
    connection.execute(tables.replacing(connection, tables.tallies, sums=True), rows)


def _mark(connection: Connection, rows: list[Mark]) -> None:
    """Update the progress of open runs; runs that were closed meanwhile do not change."""
    for far, run in groupby(rows, key=lambda row: row.checkpoint is not None):
        names = _CHECKED if far else _MARKED
        values = [
            {"run": row.room} | {f"new_{name}": getattr(row, name) for name in names} for row in run
        ]
        connection.execute(_marked(names), values)


@functools.cache
def _marked(names: tuple[str, ...]) -> sa.Update:
    row = tables.rooms
    going_on = (row.c.number == bindparam("run")) & row.c.closed.is_(None)
    new: dict[str, object] = {name: bindparam(f"new_{name}") for name in names}
    return update(row).where(going_on).values(new)


def _void(connection: Connection, rows: list[Void]) -> Ended:
    """Write results of drops that the server cannot compute: their stakes are paid back."""
    void = [
        ResultRow(row.room, ball, row.tick, None, 1.0, 0.0, 0.0, "", row.why, stake)
        for row in rows
        for ball, stake in unended_drops(connection, row.room)
    ]
    return _add_results(connection, void) if void else ()


def _close(connection: Connection, rows: list[Close]) -> None:
    for row in rows:
        connection.execute(
            update(tables.rooms)
            .where(tables.rooms.c.number == row.room)
            .values(closed=row.closed, awake=False, tick=row.tick)
        )


def _put_queues(connection: Connection, rows: list[QueueRow]) -> None:
    replacing = tables.replacing(connection, tables.queues)
    connection.execute(replacing, [asdict(row) for row in rows])


def _put_shows(connection: Connection, rows: list[ShowRow]) -> None:
    replacing = tables.replacing(connection, tables.shows)
    connection.execute(replacing, [asdict(row) for row in rows])


def _add_orders(connection: Connection, rows: list[Order]) -> None:
    values = [asdict(row) for row in rows]
    for each in values:
        del each["number"]
    connection.execute(insert(tables.operator_actions), values)


_APPLY: dict[type, Callable[[Connection, Any], Ended | None]] = {
    RoomRow: _add_rooms,
    NewDrop: facts.add_drops,
    NewInput: facts.add_inputs,
    ResultRow: _add_results,
    Mark: _mark,
    Void: _void,
    Close: _close,
    FairSessionRow: fair_store.add_sessions,
    FairOpening: fair_store.open_sessions,
    FairEnd: facts.end_sessions,
    QueueRow: _put_queues,
    ShowRow: _put_shows,
    Order: _add_orders,
    Received: webhook_store.received,
    Prune: retention.prune,
    Erase: retention.erase,
}
