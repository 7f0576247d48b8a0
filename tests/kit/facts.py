"""Drops as a test writes them to a ledger."""

from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, NewDrop


def new(row: DropRow) -> NewDrop:
    """The request that makes this fact, if it is the next one of its run."""
    names = ("seed", "x", "stake", "who", "aim", "practice", "tag")
    command = DropCommand(**{name: getattr(row, name) for name in names})
    return NewDrop(row.room, row.tick, command, used=0.0)
