"""The arguments of an arena's inputs, as `Arena.record` collects and `Arena.apply` reads them.

Only their names and types; the arena's methods check the ranges.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

import msgspec

from plinko.engine.errors import ParameterError, shorten

_HEAD = frozenset({"op", "tick"})

NUMBERS: Final[Any] = list[float] | float

Types = Mapping[str, Any]
"""The type of each argument by its name."""

NONE: Final[Types] = {}


class Operation(NamedTuple):
    """The method that carries out an input, and the types of its arguments."""

    act: Callable[..., Any]
    required: Types = NONE
    optional: Types = NONE


def read(
    entry: Mapping[str, Any], operations: Mapping[str, Operation]
) -> tuple[Callable[..., Any], dict[str, Any]]:
    """Return the method that carries out a recorded input, and its arguments.

    Raises ParameterError for an unknown operation, and for an argument that is missing, unknown or
    of the wrong type.
    """
    op = entry.get("op")
    if not isinstance(op, str) or op not in operations:
        raise ParameterError(
            f"op is {shorten(op)}: it must be one of {', '.join(operations)}", field="op"
        )
    act, required, optional = operations[op]
    types = {**required, **optional}
    values = {name: value for name, value in entry.items() if name not in _HEAD}
    for name in sorted(required.keys() - values.keys()):
        raise ParameterError(f"{op} needs the argument {name!r}", field=name)
    for name, value in values.items():
        if name not in types:
            raise ParameterError(
                f"{op} has no argument {shorten(name)}: use {', '.join(types) or 'none'}",
                field=name,
            )
        try:
            msgspec.convert(value, types[name])
        except msgspec.ValidationError as error:
            raise ParameterError(f"{name} of {op}: {error}", field=name) from error
    return act, values
