"""Statements of fair sessions: their rows, and the Merkle log of receipts with its proofs.

A receipt gets its place in the log in the transaction that commits its drop: the ledger gets the
drop, the receipt and the log's new nodes, or none of them. So refused drops leave no gap.
"""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any, Final

import msgspec
from sqlalchemy import Connection, func, insert, select, tuple_, update

from app.persistence.statements import tables
from app.persistence.statements.store import basis, result_of
from app.rooms.canonical import canonical
from app.rooms.records import FairOpening, FairSessionRow, LogLeaf, ReceiptRow, ResultRow
from engine import merkle

_AT_ONCE: Final = 400  # nodes in one SELECT: SQLite limits the number of parameters

Nodes = dict[merkle.Node, bytes]


@dataclass(frozen=True, slots=True)
class Exported:
    """The data of an export, as of one moment. `nodes` are those that its proofs need."""

    session: FairSessionRow
    board: str
    draw: str | None
    drops: list[tuple[ReceiptRow, ResultRow | None]]
    size: int
    nodes: Nodes


# Sessions.


def add_sessions(connection: Connection, rows: list[FairSessionRow]) -> None:
    connection.execute(insert(tables.fair_sessions), [asdict(row) for row in rows])


def open_sessions(connection: Connection, rows: list[FairOpening]) -> None:
    for row in rows:
        _change(connection, row.session, client_seed=row.client_seed)


def _change(connection: Connection, session: str, **values: str | None) -> None:
    chosen = tables.fair_sessions.c.id == session
    connection.execute(update(tables.fair_sessions).where(chosen).values(values))


def session(connection: Connection, session_id: str) -> tuple[FairSessionRow, int, float] | None:
    """A session, its number of drops, and the time of its last drop or of its start (Unix, s)."""
    chosen = select(tables.fair_sessions).where(tables.fair_sessions.c.id == session_id)
    found = connection.execute(chosen).mappings().first()
    if found is None:
        return None
    row = FairSessionRow(**found)
    receipt = tables.receipts.c
    last = connection.execute(
        select(receipt.number, receipt.receipt)
        .where(receipt.session == session_id)
        .order_by(receipt.number.desc())
        .limit(1)
    ).first()
    if last is None:
        return row, 0, row.opened
    return row, last.number + 1, msgspec.json.decode(last.receipt)["time"] / 1000.0


# The log.


def size(connection: Connection) -> int:
    highest = connection.scalar(select(func.max(tables.receipts.c.leaf)))
    return 0 if highest is None else int(highest) + 1


def add_leaves(connection: Connection, leaves: list[LogLeaf]) -> None:
    """Append leaves: set each leaf's index, root and signature, and write it with its nodes."""
    grown = size(connection)
    known = nodes(connection, _frontier(grown))

    def lookup(level: int, number: int) -> bytes:
        return known[level, number]

    for leaf in leaves:
        new = merkle.added(grown, leaf.leaf, lookup)
        known.update(new)
        leaf.index, grown = grown, grown + 1
        leaf.root = merkle.root(grown, lookup).hex()
        leaf.signature = leaf.sign(leaf.index, leaf.root)
        connection.execute(
            insert(tables.log_nodes),
            [{"level": at[0], "number": at[1], "hash": digest.hex()} for at, digest in new],
        )
    connection.execute(insert(tables.receipts), [_row(leaf) for leaf in leaves])


def receipt_of(leaf: LogLeaf) -> ReceiptRow:
    """The row of a leaf that has been added."""
    return ReceiptRow(**_row(leaf))


def _row(leaf: LogLeaf) -> dict[str, Any]:
    return {
        "leaf": leaf.index,
        "session": leaf.session,
        "number": leaf.number,
        "room": leaf.room,
        "ball": leaf.ball,
        "receipt": canonical(leaf.receipt).decode(),
        "root": leaf.root,
        "signature": leaf.signature,
    }


def _frontier(count: int) -> list[merkle.Node]:
    """The complete subtrees that make up a log of `count` leaves."""
    levels = range(count.bit_length())
    return [(level, (count >> level) - 1) for level in levels if count >> level & 1]


def nodes(connection: Connection, wanted: Iterable[merkle.Node]) -> Nodes:
    node, found = tables.log_nodes.c, Nodes()
    asked = list(wanted)
    for begin in range(0, len(asked), _AT_ONCE):
        some = asked[begin : begin + _AT_ONCE]
        chosen = select(tables.log_nodes).where(tuple_(node.level, node.number).in_(some))
        for row in connection.execute(chosen):
            found[row.level, row.number] = bytes.fromhex(row.hash)
    return found


def asked_by(prove: Callable[[merkle.Lookup], object]) -> set[merkle.Node]:
    """The complete subtrees that a proof needs, found by a trial run of `prove`."""
    asked: set[merkle.Node] = set()

    def note(level: int, number: int) -> bytes:
        asked.add((level, number))
        return b""

    prove(note)
    return asked


def exported(connection: Connection, session_id: str) -> Exported | None:
    """A session with its drops, and the nodes for proofs that the current log contains them."""
    found = session(connection, session_id)
    if found is None:
        return None
    row, count = found[0], size(connection)
    drops = _drops(connection, session_id)

    def proofs(lookup: merkle.Lookup) -> None:
        merkle.root(count, lookup)
        for receipt, _ in drops:
            merkle.inclusion(receipt.leaf, count, lookup)
            merkle.consistency(receipt.leaf + 1, count, lookup)

    draw = msgspec.json.decode(row.statement).get("draw_digest")
    kept = basis(connection, row.board, draw)
    assert kept.board is not None
    assert (kept.draw is None) == (draw is None)
    log = nodes(connection, asked_by(proofs))
    return Exported(row, kept.board, kept.draw, drops, count, log)


def grown(connection: Connection, since: int) -> tuple[int, Nodes]:
    """The log's size, and the nodes for its root and its consistency proof from size `since`."""
    count = size(connection)

    def proofs(lookup: merkle.Lookup) -> None:
        merkle.root(count, lookup)
        if 0 < since <= count:
            merkle.consistency(since, count, lookup)

    return count, nodes(connection, asked_by(proofs))


def _drops(connection: Connection, session_id: str) -> list[tuple[ReceiptRow, ResultRow | None]]:
    receipt, result = tables.receipts, tables.results
    joined = receipt.outerjoin(
        result, (receipt.c.room == result.c.room) & (receipt.c.ball == result.c.ball)
    )
    chosen = (
        select(*receipt.c, *result.c)  # in the order of the rows' fields
        .select_from(joined)
        .where(receipt.c.session == session_id)
        .order_by(receipt.c.number)
    )
    fields = len(receipt.c)
    return [
        (ReceiptRow(*row[:fields]), result_of(row[fields:])) for row in connection.execute(chosen)
    ]
