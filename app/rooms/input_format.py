"""What differs between kinds of rooms in how their inputs are kept in the ledger and logged."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import Any, ClassVar, Generic, TypeVar

from app.protocol import messages
from app.rooms.pending import PendingInput
from app.rooms.records import OpenDrop, ResultRow
from engine.drops.verify import Verification
from engine.errors import RecordError
from engine.json_text import JsonObject

Command = TypeVar("Command")
Row = TypeVar("Row")


def check_known(values: JsonObject, names: Collection[str], what: str) -> None:
    """Raise RecordError naming the first of `values` that is none of `names`: nothing covers it."""
    for name in values:
        if name not in names:
            known = ", ".join(names)
            raise RecordError(f"{what} has {name!r}, which is none of: {known}", field=name)


class InputFormat(ABC, Generic[Command, Row]):
    """The inputs of one kind of room as rows of the ledger and as entries of a log."""

    name: ClassVar[str]
    """Of the list of entries in a log, and of the ledger's table."""

    needed: ClassVar[tuple[str, ...]]
    """What a log must have, in the order in which it is missed."""

    optional: ClassVar[tuple[str, ...]] = ("kind", "room")
    """What it may have besides."""

    replayed: ClassVar[str] = ""
    """The part of an entry that is named when it cannot be replayed."""

    has_results: ClassVar[bool] = False
    """Whether each input has a result of its own, which the ledger keeps and a log tells."""

    @abstractmethod
    def row(self, run: int, pending: PendingInput[Command]) -> Row:
        """What the ledger keeps of an input in the run of this number."""

    @abstractmethod
    def entry(self, row: Row, result: ResultRow | None, tick: int) -> dict[str, object]:
        """One entry of a log that ends at `tick`."""

    @abstractmethod
    def check(self, where: str, number: int, entry: object) -> None:
        """Raise RecordError naming what is wrong with entry `number` of a log, found at `where`."""

    @abstractmethod
    def first_line(self, entry: JsonObject) -> bytes:
        """What of an entry went into the digest of a log of the first version."""

    def result(self, run: int, landed: messages.Landed) -> ResultRow | None:
        """What the ledger keeps of a landing in the run of this number, if anything."""
        return None

    def void(self, drop: OpenDrop, tick: int, why: str) -> ResultRow | None:
        """The result of an input that can no longer be computed as it was promised, if any."""
        return None

    def compare(
        self, where: str, entry: JsonObject, landed: messages.Landed | None
    ) -> Verification | None:
        """How what came of an entry differs from what its log says; None where it does not."""
        return None


AnyFormat = InputFormat[Any, Any]
"""That of any kind of room."""
