"""All faults of a board at once: checks go on after one fails, and one error names them all."""

from collections.abc import Callable
from typing import Any, Final

from engine.errors import BoardError, Fault

MOST: Final = 20
"""Faults that one error names. Whoever has more than these has one cause for most of them."""


class Faults:
    """The faults found so far. `take` runs a check; `end` raises one error for all that failed."""

    def __init__(self) -> None:
        self.found: list[Fault] = []

    @property
    def full(self) -> bool:
        """Whether there are as many as an error names, so that further checks are idle."""
        return len(self.found) >= MOST

    def take(self, check: Callable[..., Any], *values: Any) -> Any:
        """What `check` returns, or None where it raises BoardError."""
        if self.full:
            return None
        try:
            return check(*values)
        except BoardError as error:
            self.found += [fault for fault in error.faults if fault not in self.found]
            return None

    def add(self, field: str, message: str) -> None:
        """Note what is wrong at `field`, a path in the JSON form."""
        self.found.append(Fault(field, message))

    def end(self) -> None:
        """Raise a BoardError that names all faults, if there are any."""
        faults = tuple(self.found[:MOST])
        if faults:
            raise BoardError(_message(faults), field=faults[0].field, faults=faults)


def _message(faults: tuple[Fault, ...]) -> str:
    first, *others = [fault.message for fault in faults]
    if not others:
        return first
    count = f"{len(others)} more fault{'s' * (len(others) > 1)}"
    if len(faults) == MOST:
        count = f"at least {count}"
    return f"{first} ({count}: {'; '.join(others)})"
