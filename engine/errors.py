"""The engine's errors. Every message names the bad value and says what would be right.

`PlinkoError` is the root of all errors, EngineError of the engine's, and AppError
(`plinko.app.errors`) of all others. All that are about values are ValueErrors too.
"""

from typing import NamedTuple


def shorten(value: object, limit: int = 60) -> str:
    """`repr` for an error's message, cut so that a huge value does not make a huge message."""
    try:
        shown = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        shown = "an integer of thousands of digits"
    return shown if len(shown) <= limit else shown[: limit - 3] + "..."


class PlinkoError(Exception):
    """Base of all errors that this package raises."""

    def __init__(self, message: str, *, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class EngineError(PlinkoError):
    """Base of all errors that the engine raises."""


class Fault(NamedTuple):
    """One fault of a board: its path in the JSON form, and the message."""

    field: str
    message: str


class BoardError(EngineError, ValueError):
    """A board that cannot be played. `field` is a path in its JSON form, such as `pegs[3].radius`.

    `faults` lists all faults that were found together. Overlapping parts and traps are only found
    on a board whose values are all valid.
    """

    def __init__(self, message: str, *, field: str = "", faults: tuple[Fault, ...] = ()) -> None:
        super().__init__(message, field=field)
        self.faults = faults or (Fault(field, message),)


class EffortError(EngineError, ValueError):
    """A call would compute longer than this process allows; see `limit_calls`."""


class SeedError(EngineError, ValueError):
    """A seed that is not an integer 0 <= seed < 2^64."""


class ParameterError(EngineError, ValueError):
    """A parameter, such as a solver's, a drop's or an arena's, that is invalid."""


class RecordError(EngineError, ValueError):
    """A record, snapshot or result with a field that is missing or invalid."""


class JsonSyntaxError(EngineError, ValueError):
    """Text that is not JSON, or is nested too deeply."""


class JsonValueError(EngineError, ValueError):
    """JSON with a duplicate key, or a value that readers could understand differently.

    `field` is its path.
    """


class MissingPartError(EngineError, ImportError):
    """A part of the program is not installed here, such as a package for videos or tables."""


class ClusterError(EngineError):
    """A cluster that does not answer, has no workers, or has workers with other physics."""
