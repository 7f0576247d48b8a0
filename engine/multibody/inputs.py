"""The arguments of an arena's inputs, as `Arena.record` collects and `Arena.apply` reads them.

Only their names and types; the arena's methods check the ranges.
"""

from collections.abc import Callable, Mapping
from typing import Any, NotRequired, TypedDict, get_type_hints

import msgspec

from plinko.engine.errors import ParameterError

_HEAD = frozenset({"op", "tick"})

Numbers = list[float] | float
Operations = Mapping[str, tuple[Callable[..., Any], type]]
"""By name of an input: the method that carries it out, and the type of its arguments."""


class Nothing(TypedDict):
    """No arguments."""


class Values(TypedDict, total=False):
    """A ball's values in m, rad, m/s, rad/s, kg/m^2."""

    theta: float
    vx: float
    vy: float
    omega: float
    radius: float
    density: float
    restitution: float
    friction: float


class Added(Values):
    """A new ball at (x, y) in m."""

    x: float
    y: float


class ManyAdded(TypedDict):
    """New balls; each value is a list, or one number for all balls."""

    x: Numbers
    y: Numbers
    ids: NotRequired[list[int] | None]
    theta: NotRequired[Numbers]
    vx: NotRequired[Numbers]
    vy: NotRequired[Numbers]
    omega: NotRequired[Numbers]
    radius: NotRequired[Numbers]
    density: NotRequired[Numbers]
    restitution: NotRequired[Numbers]
    friction: NotRequired[Numbers]


class Ball(TypedDict):
    """A ball, by its id."""

    ball: int


class Balls(TypedDict):
    """Balls, by their ids."""

    balls: list[int]


class Kick(Ball):
    """A change of velocity in m/s and of spin in rad/s."""

    dvx: float
    dvy: float
    domega: NotRequired[float]


class Impulse(Ball):
    """An impulse in N s."""

    jx: float
    jy: float


class EditAll(Values, total=False):
    """New values, which may include a new place."""

    x: float
    y: float


class Edit(EditAll, Ball):
    """New values of a ball."""


class Configure(TypedDict, total=False):
    """New values of some ArenaSettings."""

    gravity: float
    drag: float
    damping: float
    correction: float
    dt: float
    substeps: int
    max_speed: float | None
    sleeping: bool


def read(
    entry: Mapping[str, Any], operations: Operations
) -> tuple[Callable[..., Any], dict[str, Any]]:
    """Return the method that carries out a recorded input, and its arguments.

    Raises ParameterError for an unknown operation, and for an argument that is missing, unknown or
    of the wrong type.
    """
    op = entry.get("op")
    if not isinstance(op, str) or op not in operations:
        raise ParameterError(
            f"op is {op!r:.40}: it must be one of {', '.join(operations)}", field="op"
        )
    act, kind = operations[op]
    types = get_type_hints(kind)
    values = {name: value for name, value in entry.items() if name not in _HEAD}
    for name in sorted(kind.__required_keys__ - values.keys()):  # type: ignore[attr-defined]
        raise ParameterError(f"{op} needs the argument {name!r}", field=name)
    for name, value in values.items():
        if name not in types:
            raise ParameterError(
                f"{op} has no argument {name!r:.40}: use {', '.join(types) or 'none'}", field=name
            )
        try:
            msgspec.convert(value, types[name])
        except msgspec.ValidationError as error:
            raise ParameterError(f"{name} of {op}: {error}", field=name) from error
    return act, values
