"""Collects all faults of a board: checks continue after a failure, and one error names them all."""

from collections.abc import Callable, Iterable
from typing import Any, Final, TypeVar

from plinko.engine.errors import BoardError, Fault

T = TypeVar("T")

MOST: Final = 20
"""Most faults that one error names. More than that usually have one cause."""


class Faults:
    """Faults of one board. `take` runs a check; `end` raises one error for all that failed."""

    def __init__(self) -> None:
        self.found: list[Fault] = []

    @property
    def full(self) -> bool:
        """Whether MOST faults were found, so that further checks are pointless."""
        return len(self.found) >= MOST

    def take(self, check: Callable[..., Any], *values: Any) -> Any:
        """Return `check(*values)`, or None if it raises BoardError or enough faults were found."""
        if self.full:
            return None
        try:
            return check(*values)
        except BoardError as error:
            self.found += [fault for fault in error.faults if fault not in self.found]
            return None

    def add(self, field: str, message: str) -> None:
        """Add the fault `message` at `field`, a path in the JSON form."""
        self.found.append(Fault(field, message))

    def end(self) -> None:
        """Raise one BoardError for all faults, if any was found."""
        faults = tuple(self.found[:MOST])
        if faults:
            raise BoardError(_message(faults), field=faults[0].field, faults=faults)


def checked_items(check: Callable[[Any, str], T], items: Iterable[Any], path: str) -> tuple[T, ...]:
    """Each of `items` checked as check(item, path[i]); one BoardError for all that fail."""
    faults = Faults()
    found = tuple(faults.take(check, item, f"{path}[{i}]") for i, item in enumerate(items))
    faults.end()
    return found


def _message(faults: tuple[Fault, ...]) -> str:
    first, *others = [fault.message for fault in faults]
    if not others:
        return first
    count = f"{len(others)} more fault{'s' * (len(others) > 1)}"
    if len(faults) == MOST:
        count = f"at least {count}"
    return f"{first} ({count}: {'; '.join(others)})"
