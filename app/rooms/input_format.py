"""The interface by which each kind of room writes its inputs to the ledger and to a log."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import Any, ClassVar, Generic, TypeVar

from plinko.app.rooms.records import ResultRow
from plinko.engine.drops.verify import Verification
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject

Row = TypeVar("Row")


def check_known(values: JsonObject, names: Collection[str], what: str) -> None:
    """Raise RecordError for the first field not among `names`: no check would cover it."""
    for name in values:
        if name not in names:
            known = ", ".join(names)
            raise RecordError(f"{what} has {name!r}, which is not one of: {known}", field=name)


class InputFormat(ABC, Generic[Row]):
    """The inputs of one kind of room as rows of the ledger and as entries of a log."""

    name: ClassVar[str]
    """The name of the list of entries in a log, and of the ledger's table."""

    needed: ClassVar[tuple[str, ...]]
    """The required fields of a log; an error names the first one missing in this order."""

    optional: ClassVar[tuple[str, ...]] = ("kind", "room")
    """Further fields that a log may have."""

    replayed: ClassVar[str] = ""
    """The part of an entry that an error names if the entry cannot be replayed."""

    has_results: ClassVar[bool] = False
    """Whether the ledger and the log have a result for each input."""

    @abstractmethod
    def entry(self, row: Row, result: ResultRow | None, tick: int) -> dict[str, object]:
        """One entry of a log that ends at `tick`."""

    @abstractmethod
    def check(self, where: str, number: int, entry: object) -> None:
        """Raise RecordError if entry `number` of a log, at the path `where`, is invalid."""

    def compare(
        self, where: str, entry: JsonObject, result: ResultRow | None
    ) -> Verification | None:
        """The first difference between a replayed result and its entry; None if they agree."""
        return None


AnyFormat = InputFormat[Any]
"""The format of either kind of room."""
