"""Statements of fair sessions: their rows, and the Merkle log of receipts with its proofs.

A receipt gets its place in the log in the transaction that commits its drop: the ledger gets the
drop, the receipt and the log's new nodes, or none of them. So refused drops leave no gap.
"""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any, Final

import msgspec
from sqlalchemy import Connection, func, insert, select, tuple_, update

from plinko.app.errors import PrunedError
from plinko.app.persistence.statements import history, tables
from plinko.app.persistence.statements.store import RECEIPTS, basis, receipt_of, result_of
from plinko.app.protocol.messages import SignedReceipt
from plinko.app.rooms.records import (
    LOG_LEAVES,
    FairOpening,
    FairSessionRow,
    LogLeaf,
    ResultRow,
)
from plinko.engine import merkle

_AT_ONCE: Final = 400  # nodes in one SELECT: SQLite limits the number of parameters

Nodes = dict[merkle.Node, bytes]


@dataclass(frozen=True, slots=True)
class Exported:
    """The data of an export, as of one moment. `nodes` are those that its proofs need.

    log: the id of the log with the session's receipts; None for the first log.
    """

    session: FairSessionRow
    board: str
    draw: str | None
    drops: list[tuple[SignedReceipt, ResultRow | None]]
    log: str | None
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
        select(receipt.number, receipt.time)
        .where(receipt.session == session_id)
        .order_by(receipt.number.desc())
        .limit(1)
    ).first()
    if row.end is not None:  # its receipts may have been pruned
        return row, msgspec.json.decode(row.end)["drops"], row.opened
    if last is None:
        return row, 0, row.opened
    return row, last.number + 1, last.time / 1000.0


def unended(connection: Connection) -> list[tuple[str, str, int]]:
    """All open sessions: id, the server's secret in hexadecimal, and number of drops."""
    row, receipt = tables.fair_sessions.c, tables.receipts.c
    counts = select(receipt.session, (func.max(receipt.number) + 1).label("drops"))
    counted = counts.group_by(receipt.session).subquery()
    chosen = (
        select(row.id, row.server_seed, func.coalesce(counted.c.drops, 0))
        .outerjoin(counted, counted.c.session == row.id)
        .where(row.end.is_(None))
        .order_by(row.id)
    )
    return [(each[0], each[1], int(each[2])) for each in connection.execute(chosen)]


def unended_before(connection: Connection, before: float) -> list[str]:
    """The ids of open sessions that began before this Unix time, in s."""
    row = tables.fair_sessions.c
    chosen = select(row.id).where(row.end.is_(None), row.opened < before).order_by(row.opened)
    return list(connection.execute(chosen).scalars())


def unended_since(connection: Connection, begin: float, end: float) -> int:
    """The number of open sessions that began between two Unix times, in s."""
    row = tables.fair_sessions.c
    chosen = select(func.count()).where(row.end.is_(None), row.opened >= begin, row.opened < end)
    return int(connection.scalar(chosen) or 0)


def end(connection: Connection, session: str, statement: str, signature: str) -> None:
    """End a session with this signed statement, JSON."""
    _change(connection, session, end=statement, end_signature=signature)


def newest_signed(connection: Connection) -> tuple[str, str] | None:
    """A statement, JSON, that the ledger's present key has signed, and its signature."""
    row = tables.fair_sessions.c
    chosen = select(row.statement, row.signature).order_by(row.opened.desc()).limit(1)
    found = connection.execute(chosen).first()
    if found is not None:
        return found.statement, found.signature
    restores = history.restores(connection)
    return (restores[-1].statement, restores[-1].signature) if restores else None


# The log.


def size(connection: Connection, log: int) -> int:
    """The number of leaves of a log, whose receipts may have been pruned."""
    node, first = tables.log_nodes.c, log * LOG_LEAVES
    leaves = (node.level == 0) & (node.number >= first) & (node.number < first + LOG_LEAVES)
    highest = connection.scalar(select(func.max(node.number)).where(leaves))
    return 0 if highest is None else int(highest) + 1 - first


def add_leaves(connection: Connection, leaves: list[LogLeaf]) -> None:
    """Append leaves: set each leaf's index, root and signature, and write it with its nodes."""
    log = history.log_number(connection)
    log_id = _log_id(connection, log)
    grown = size(connection, log)
    known = nodes(connection, log, _frontier(grown))

    def lookup(level: int, number: int) -> bytes:
        return known[level, number]

    for leaf in leaves:
        new = merkle.added(grown, leaf.leaf, lookup)
        known.update(new)
        leaf.log, leaf.index, grown = log, grown, grown + 1
        leaf.root = merkle.root(grown, lookup).hex()
        leaf.signature = leaf.sign(leaf.index, leaf.root, log_id)
        rows = [
            {"level": level, "number": number + _first_node(log, level), "hash": digest.hex()}
            for (level, number), digest in new
        ]
        connection.execute(insert(tables.log_nodes), rows)
    connection.execute(insert(tables.receipts), [_row(leaf) for leaf in leaves])


def _log_id(connection: Connection, log: int) -> str | None:
    found = history.log_id(connection, log)
    return None if found == history.FIRST_LOG else found


def _first_node(log: int, level: int) -> int:
    """The number of the first node of a log at this level."""
    return log * LOG_LEAVES >> level


def _row(leaf: LogLeaf) -> dict[str, Any]:
    return {
        "leaf": leaf.log * LOG_LEAVES + leaf.index,
        "session": leaf.session,
        "number": leaf.number,
        "room": leaf.room,
        "ball": leaf.ball,
        "time": leaf.receipt["time"],
        "root": leaf.root,
        "signature": leaf.signature,
    }


def _frontier(count: int) -> list[merkle.Node]:
    """The complete subtrees that make up a log of `count` leaves."""
    levels = range(count.bit_length())
    return [(level, (count >> level) - 1) for level in levels if count >> level & 1]


def nodes(connection: Connection, log: int, wanted: Iterable[merkle.Node]) -> Nodes:
    node, found = tables.log_nodes.c, Nodes()
    asked = [(level, number + _first_node(log, level)) for level, number in wanted]
    for begin in range(0, len(asked), _AT_ONCE):
        some = asked[begin : begin + _AT_ONCE]
        chosen = select(tables.log_nodes).where(tuple_(node.level, node.number).in_(some))
        for row in connection.execute(chosen):
            number = row.number - _first_node(log, row.level)
            found[row.level, number] = bytes.fromhex(row.hash)
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
    """A session with its drops, and the nodes for proofs that their log contains them."""
    found = session(connection, session_id)
    if found is None:
        return None
    (row, count, _), drops = found, _drops(connection, session_id)
    if len(drops) < count:
        raise PrunedError(
            f"the server has deleted old drops of session {session_id!r}; receipts and exports "
            "that you have stay provable",
            field="session",
        )
    log = _log_of(connection, row)
    count = size(connection, log)

    def proofs(lookup: merkle.Lookup) -> None:
        merkle.root(count, lookup)
        for receipt, _ in drops:
            merkle.inclusion(receipt.index, count, lookup)
            merkle.consistency(receipt.index + 1, count, lookup)

    draw = msgspec.json.decode(row.statement).get("draw_digest")
    kept = basis(connection, row.board, draw)
    assert kept.board is not None
    assert (kept.draw is None) == (draw is None)
    found_nodes = nodes(connection, log, asked_by(proofs))
    log_id = _log_id(connection, log)
    return Exported(row, kept.board, kept.draw, drops, log_id, count, found_nodes)


def _log_of(connection: Connection, row: FairSessionRow) -> int:
    """The number of a session's log. Of a void one without drops, it is that before the restore."""
    receipt = tables.receipts.c
    leaf = connection.scalar(select(receipt.leaf).where(receipt.session == row.id).limit(1))
    if leaf is not None:
        return int(leaf) // LOG_LEAVES
    void = None if row.end is None else msgspec.json.decode(row.end).get("void")
    began = [each.number for each in history.restores(connection) if each.log == void]
    return began[0] - 1 if began else history.log_number(connection)


def grown(connection: Connection, since: int) -> tuple[str | None, int, Nodes]:
    """The current log's id and size, and the nodes for its root and its proof from size `since`."""
    log = history.log_number(connection)
    count = size(connection, log)

    def proofs(lookup: merkle.Lookup) -> None:
        merkle.root(count, lookup)
        if 0 < since <= count:
            merkle.consistency(since, count, lookup)

    return _log_id(connection, log), count, nodes(connection, log, asked_by(proofs))


def _drops(connection: Connection, session_id: str) -> list[tuple[SignedReceipt, ResultRow | None]]:
    receipt, result = tables.receipts.c, tables.results.c
    chosen = (
        RECEIPTS.add_columns(*result)
        .outerjoin(tables.results, (receipt.room == result.room) & (receipt.ball == result.ball))
        .where(receipt.session == session_id)
        .order_by(receipt.number)
    )
    fields = len(RECEIPTS.selected_columns)
    rows = connection.execute(chosen)
    return [(receipt_of(*row[:fields]), result_of(row[fields:])) for row in rows]
