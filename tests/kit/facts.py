"""Drops as a test writes them to a ledger."""

from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, NewDrop


def new(row: DropRow, used: float = 0.0) -> NewDrop:
    """The request that makes this fact, if it is the next one of its run.

    used: when, Unix time in s; with 0 the run's row does not change.
    """
    names = ("seed", "x", "stake", "who", "aim", "practice", "tag")
    command = DropCommand(**{name: getattr(row, name) for name in names})
    return NewDrop(row.room, row.tick, command, used=used)
