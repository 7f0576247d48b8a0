"""Checks each value of a board by itself: type, range, count, order. Errors name path and value.

`plinko.engine.board.checks` checks the board's geometry.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from numbers import Real
from types import MappingProxyType
from typing import Any, Final, TypeVar

from plinko.engine import plain_text
from plinko.engine.board.faults import Faults
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Label, Peg, Wall
from plinko.engine.errors import BoardError

T = TypeVar("T")

MAX_PEGS: Final = 20_000
MAX_WALLS: Final = 2_000
MAX_BINS: Final = 1_000
MAX_SLOTS: Final = 1_000
MAX_NAME: Final = 100
"""Characters."""

MAX_LABEL: Final = 40
"""Characters, after NFC."""

COLOUR: Final = "^#[0-9a-f]{6}$"

MAX_COORDINATE: Final = 1e6
"""m. At larger coordinates, the spacing of float64 values approaches a micrometre."""

MIN_RADIUS: Final = 1e-6
"""m. The square of a smaller radius would be lost in the rounding of squared distances."""

MAX_RADIUS: Final = 1e4
MAX_DENSITY: Final = 1e9
MIN_DENSITY: Final = 1e-9
MAX_FRICTION: Final = 10.0
"""Rubber on rubber is near 1. Beyond ten, the motion hardly changes and only rounding grows."""

MIN_GRAVITY: Final = 1e-6
MAX_GRAVITY: Final = 1e4
MAX_DRAG: Final = 1e3
"""1/s. At this limit a ball on Earth falls one centimetre per second."""

MAX_MULTIPLIER: Final = 1e9


def shown(value: object) -> str:
    """The repr of `value` for an error message, cut to 60 characters."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        text = "an integer of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."


def fail(field: str, value: object, wanted: str) -> BoardError:
    """Make the error for `value` at `field`; `wanted` says what would be right."""
    return BoardError(f"{field} is {shown(value)}: {wanted}", field=field)


def number(
    value: Any,
    field: str,
    low: float = -MAX_COORDINATE,
    high: float = MAX_COORDINATE,
    wanted: str = "",
) -> float:
    """Return `value` as a float in [low, high], -0.0 as 0.0; otherwise raise BoardError."""
    if isinstance(value, bool) or not isinstance(value, int | float | Real):
        raise fail(field, value, "it must be a number")
    try:
        result = float(value)
    except OverflowError:
        raise fail(field, value, f"it must be from {low:g} to {high:g}") from None
    if not math.isfinite(result):
        raise fail(field, value, "it must be finite")
    if not low <= result <= high:
        raise fail(field, value, wanted or f"it must be from {low:g} to {high:g}")
    return result + 0.0


def radius(value: Any, field: str) -> float:
    wanted = f"a radius must be greater than 0, from {MIN_RADIUS:g} to {MAX_RADIUS:g} m"
    return number(value, field, MIN_RADIUS, MAX_RADIUS, wanted)


def name(value: Any) -> str:
    wanted = f"a name must be 1 to {MAX_NAME} printable characters"
    if isinstance(value, str) and 0 < len(value) <= MAX_NAME and plain_text.is_printable(value):
        return value
    raise fail("name", value, wanted)


def gravity(value: Any) -> float:
    """Return `value` as gravity in m/s^2; without gravity no drop would end."""
    wanted = (
        f"gravity must be from {MIN_GRAVITY:g} to {MAX_GRAVITY:g} m/s^2, pointing down, "
        "or no ball would ever reach a bin"
    )
    return number(value, "gravity", MIN_GRAVITY, MAX_GRAVITY, wanted)


def drag(value: Any) -> float:
    return number(value, "drag", 0.0, MAX_DRAG, f"drag must be from 0 to {MAX_DRAG:g} 1/s")


def size(value: Any, field: str) -> float:
    """Return `value` as the picture's width or height in m."""
    wanted = f"it must be greater than 0, from {MIN_RADIUS:g} to {2 * MAX_COORDINATE:g} m"
    return number(value, field, MIN_RADIUS, 2 * MAX_COORDINATE, wanted)


def _restitution(value: Any, field: str) -> float:
    return number(value, field, 0.0, 1.0, "restitution must be from 0 to 1")


def _friction(value: Any, field: str) -> float:
    return number(value, field, 0.0, MAX_FRICTION, f"friction must be from 0 to {MAX_FRICTION:g}")


def material(value: Any, field: str) -> Material:
    part = instance(value, Material, field)
    faults = Faults()
    restitution = faults.take(_restitution, part.restitution, f"{field}.restitution")
    friction = faults.take(_friction, part.friction, f"{field}.friction")
    faults.end()
    return Material(restitution, friction)


def ball(value: Any) -> BallSpec:
    part = instance(value, BallSpec, "ball")
    wanted = f"density must be greater than 0, from {MIN_DENSITY:g} to {MAX_DENSITY:g} kg/m^2"
    faults = Faults()
    checked = (
        faults.take(radius, part.radius, "ball.radius"),
        faults.take(number, part.density, "ball.density", MIN_DENSITY, MAX_DENSITY, wanted),
        faults.take(_restitution, part.restitution, "ball.restitution"),
        faults.take(_friction, part.friction, "ball.friction"),
    )
    faults.end()
    return BallSpec(*checked)


def instance(value: Any, kind: type[T], field: str) -> T:
    """Return `value` if it is a `kind`; BoardError otherwise."""
    if not isinstance(value, kind):
        raise fail(field, value, f"it must be a {kind.__name__}")
    return value


def items(value: Any, field: str, limit: int) -> tuple[Any, ...]:
    """Return `value` as a tuple of at most `limit` items."""
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        raise fail(field, value, "it must be a list")
    result = tuple(value)
    if len(result) > limit:
        raise BoardError(
            f"{field} has {len(result)} items: at most {limit} are allowed", field=field
        )
    return result


def pegs(value: Any) -> tuple[Peg, ...]:
    faults = Faults()
    checked = tuple(
        faults.take(_peg, peg, f"pegs[{i}]") for i, peg in enumerate(items(value, "pegs", MAX_PEGS))
    )
    faults.end()
    return checked


def _peg(value: Any, field: str) -> Peg:
    peg = instance(value, Peg, field)
    return Peg(
        number(peg.x, f"{field}.x"),
        number(peg.y, f"{field}.y"),
        radius(peg.radius, f"{field}.radius"),
    )


def walls(value: Any) -> tuple[Wall, ...]:
    faults = Faults()
    checked = tuple(
        faults.take(_wall, wall, f"walls[{i}]")
        for i, wall in enumerate(items(value, "walls", MAX_WALLS))
    )
    faults.end()
    return checked


def _wall(value: Any, field: str) -> Wall:
    wall = instance(value, Wall, field)
    result = Wall(
        number(wall.x1, f"{field}.x1"),
        number(wall.y1, f"{field}.y1"),
        number(wall.x2, f"{field}.x2"),
        number(wall.y2, f"{field}.y2"),
    )
    dx, dy = result.x2 - result.x1, result.y2 - result.y1
    if dx * dx + dy * dy < MIN_RADIUS * MIN_RADIUS:
        raise BoardError(
            f"{field} from ({result.x1!r}, {result.y1!r}) to ({result.x2!r}, {result.y2!r}) "
            f"has no length: its ends must be at least {MIN_RADIUS:g} m apart",
            field=field,
        )
    return result


def bins(value: Any) -> Bins:
    """Return `value` as Bins with increasing edges and one multiplier for each bin."""
    part = instance(value, Bins, "bins")
    edges = _numbers(part.edges, "bins.edges", MAX_BINS + 1)
    if len(edges) < 2:
        raise fail("bins.edges", part.edges, "it needs at least 2 edges, one bin's left and right")
    for i in range(1, len(edges)):
        if edges[i] <= edges[i - 1]:
            raise fail(f"bins.edges[{i}]", edges[i], f"it must be greater than {edges[i - 1]!r}")
    payouts = _numbers(part.multipliers, "bins.multipliers", MAX_BINS, 0.0, MAX_MULTIPLIER)
    if len(payouts) != len(edges) - 1:
        raise BoardError(
            f"bins.multipliers has {len(payouts)} values: {len(edges)} edges make "
            f"{len(edges) - 1} bins, and each needs one",
            field="bins.multipliers",
        )
    return Bins(number(part.y, "bins.y"), edges, payouts, _labels(part.labels, len(payouts)))


def _labels(value: Any, count: int) -> tuple[Label | None, ...]:
    """Return `value` as one label or None for each bin; empty if all are None."""
    labels = items(value, "bins.labels", MAX_BINS)
    if labels and len(labels) != count:
        raise BoardError(
            f"bins.labels has {len(labels)} values: there are {count} bins, and each needs one, "
            "which may be null",
            field="bins.labels",
        )
    faults = Faults()
    checked = tuple(
        faults.take(_label, label, f"bins.labels[{i}]") for i, label in enumerate(labels)
    )
    faults.end()
    return checked if any(label is not None for label in checked) else ()


def _label(value: Any, field: str) -> Label | None:
    if value is None:
        return None
    label = instance(value, Label, field)
    text = plain_text.normal(label.text)
    right = plain_text.fault(text, MAX_LABEL)
    if right is not None:
        raise fail(f"{field}.text", label.text, f"it must be {right}")
    colour = label.colour
    if colour is not None and not _is_colour(colour):
        raise fail(f"{field}.colour", colour, "it must be # and six digits of 0-9 and a-f")
    return Label(text, colour)


def _is_colour(value: Any) -> bool:
    return isinstance(value, str) and re.fullmatch(COLOUR, value) is not None


def drop_zone(value: Any) -> DropZone:
    part = instance(value, DropZone, "drop")
    faults = Faults()
    checked = (
        faults.take(number, part.x, "drop.x"),
        faults.take(number, part.y, "drop.y"),
        faults.take(number, part.jitter, "drop.jitter", 0.0),
        faults.take(_numbers, part.slots, "drop.slots", MAX_SLOTS),
        faults.take(number, part.reach, "drop.reach", 0.0),
        faults.take(number, part.aim, "drop.aim", 0.0),
    )
    faults.end()
    return DropZone(*checked)


def _numbers(
    value: Any,
    field: str,
    limit: int,
    low: float = -MAX_COORDINATE,
    high: float = MAX_COORDINATE,
) -> tuple[float, ...]:
    values: Sequence[Any] = items(value, field, limit)
    return tuple(number(v, f"{field}[{i}]", low, high) for i, v in enumerate(values))


CHECKS: Final[Mapping[str, Callable[[Any], Any]]] = MappingProxyType(
    {
        "name": name,
        "width": partial(size, field="width"),
        "height": partial(size, field="height"),
        "gravity": gravity,
        "drag": drag,
        "ball": ball,
        "pegs": pegs,
        "peg_material": partial(material, field="peg_material"),
        "walls": walls,
        "wall_material": partial(material, field="wall_material"),
        "bins": bins,
        "drop": drop_zone,
    }
)
"""The check of each field of a board, in the order in which errors list their faults."""
