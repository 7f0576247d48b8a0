"""Drops as a test writes them to a ledger."""

from app.rooms.records import DropRow, NewDrop


def new(row: DropRow) -> NewDrop:
    """The request that makes this fact, if it is the next one of its run."""
    names = ("room", "tick", "seed", "x", "stake", "who", "aim", "practice")
    return NewDrop(used=0.0, **{name: getattr(row, name) for name in names}, tag=row.tag)
