"""Running sums of all stakes and payouts since the ledger began, by board and size of the stake.

Each result is counted once, in the transaction that first writes it, even if it is written again
after a crash. It stays counted when its room is pruned.
"""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Final

from sqlalchemy import Connection, select, tuple_

from plinko.app.persistence.statements import tables

_AT_ONCE: Final = 400  # results in one SELECT: SQLite limits the number of parameters

Key = tuple[str, int, bool]


@dataclass(slots=True)
class Total:
    """Sums over the drops of a board with stakes from `stake` to ten times `stake` (exclusive).

    Only drops that ended in a bin count, and none of rooms with a draw, whose odds differ. aimed:
    whether the player chose the middle of the starts. staked, paid: in minor units; squares: sum of
    the stakes' squares.
    """

    board: str
    stake: int
    aimed: bool
    plays: int = 0
    staked: int = 0
    squares: float = 0.0
    paid: int = 0


def band(stake: int) -> int:
    """The largest power of ten up to a stake above 0, for example 100 for 250."""
    power: int = 10 ** (len(str(stake)) - 1)
    return power


def count(connection: Connection, results: Sequence[tuple[int, int]]) -> None:
    """Add new results, given as rows of room and ball, to the sums."""
    found: dict[Key, Total] = {}
    for begin in range(0, len(results), _AT_ONCE):
        for row in _staked(connection, results[begin : begin + _AT_ONCE]):
            key = (row.board, band(row.stake), row.aim is not None)
            total = found.setdefault(key, Total(*key))
            total.plays += 1
            total.staked += row.stake
            total.squares += float(row.stake) ** 2
            total.paid += row.payout
    if found:
        ordered = [_values(found[key]) for key in sorted(found)]
        adding = tables.replacing(connection, tables.totals, sums=True)
        connection.execute(adding, ordered)


def read(connection: Connection) -> list[Total]:
    order = tables.totals.c
    chosen = select(tables.totals).order_by(order.board, order.stake, order.aimed)
    return [Total(**row) for row in connection.execute(chosen).mappings()]


def _staked(connection: Connection, results: Sequence[tuple[int, int]]) -> Iterator[Any]:
    drop, result = tables.drops.c, tables.results.c
    keys = list(results)
    chosen = (
        select(tables.rooms.c.board, drop.stake, drop.aim, result.payout)
        .select_from(tables.results.join(tables.drops).join(tables.rooms))
        .where(tuple_(result.room, result.ball).in_(keys))
        .where(drop.stake > 0, result.bin.is_not(None))
        .where(tables.rooms.c.draw.is_(None))  # a draw's odds are not the board's
    )
    yield from connection.execute(chosen)


def _values(total: Total) -> dict[str, object]:
    return dict(zip(tables.totals.c.keys(), astuple(total), strict=True))
