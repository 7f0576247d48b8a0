"""Checks each value of a board by itself: type, range (form.py), count, order.

Errors name path and value.

`plinko.engine.board.checks` checks the board's geometry.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from numbers import Real
from typing import Any, Final, TypeVar

from plinko.engine import plain_text
from plinko.engine.board.faults import Faults, checked_items
from plinko.engine.board.form import (
    COLOUR,
    FORM,
    MAX_BINS,
    MAX_LABEL,
    MAX_NAME,
    MIN_RADIUS,
    Field,
    field_of,
)
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Label, Peg, Wall
from plinko.engine.errors import BoardError, shorten

T = TypeVar("T")

COORDINATE: Final = field_of("peg", "x")


def fail(field: str, value: object, wanted: str) -> BoardError:
    """Make the error for `value` at `field`; `wanted` says what would be right."""
    return BoardError(f"{field} is {shorten(value)}: {wanted}", field=field)


def number(value: Any, field: str, kind: Field = COORDINATE) -> float:
    """Return `value` as a float in the range of `kind`, -0.0 as 0.0; otherwise raise BoardError."""
    if isinstance(value, bool) or not isinstance(value, int | float | Real):
        raise fail(field, value, "it must be a number")
    try:
        result = float(value)
    except OverflowError:
        raise fail(field, value, kind.rule) from None
    if not math.isfinite(result):
        raise fail(field, value, "it must be finite")
    if not kind.low <= result <= kind.high:
        raise fail(field, value, kind.rule)
    return result + 0.0


def name(value: Any) -> str:
    wanted = f"a name must be 1 to {MAX_NAME} printable characters"
    if isinstance(value, str) and 0 < len(value) <= MAX_NAME and plain_text.is_printable(value):
        return value
    raise fail("name", value, wanted)


def part(value: Any, field: str, kind: type[T], fields: tuple[Field, ...]) -> T:
    """Return `value`, a `kind` at the path `field`, with each of its fields checked."""
    given = instance(value, kind, field)
    faults = Faults()
    checked = [
        faults.take(_numbers if each.most else number, getattr(given, each.name),
                    f"{field}.{each.name}", each)
        for each in fields
    ]  # fmt: skip
    faults.end()
    return kind(*checked)


def material(value: Any, field: str) -> Material:
    return part(value, field, Material, FORM["material"])


def drop_zone(value: Any) -> DropZone:
    return part(value, "drop", DropZone, FORM["drop"])


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
    return _parts(value, "pegs", lambda peg, path: _row(peg, path, Peg, FORM["peg"]))


def walls(value: Any) -> tuple[Wall, ...]:
    return _parts(value, "walls", _wall)


def _parts(value: Any, field: str, check: Callable[[Any, str], T]) -> tuple[T, ...]:
    return checked_items(check, items(value, field, field_of("board", field).most), field)


def _row(value: Any, field: str, kind: type[T], fields: tuple[Field, ...]) -> T:
    """`part` of numbers, one of thousands: it names only its first fault, and takes less time."""
    given = instance(value, kind, field)
    return kind(*[number(getattr(given, f.name), f"{field}.{f.name}", f) for f in fields])


def _wall(value: Any, field: str) -> Wall:
    wall = _row(value, field, Wall, FORM["wall"])
    dx, dy = wall.x2 - wall.x1, wall.y2 - wall.y1
    if dx * dx + dy * dy < MIN_RADIUS * MIN_RADIUS:
        raise BoardError(
            f"{field} from ({wall.x1!r}, {wall.y1!r}) to ({wall.x2!r}, {wall.y2!r}) "
            f"has no length: its ends must be at least {MIN_RADIUS:g} m apart",
            field=field,
        )
    return wall


def bins(value: Any) -> Bins:
    """Return `value` as Bins with increasing edges and one multiplier for each bin."""
    given = instance(value, Bins, "bins")
    height, borders, pays, _ = FORM["bins"]
    edges = _numbers(given.edges, "bins.edges", borders)
    if len(edges) < 2:
        raise fail("bins.edges", given.edges, "it needs at least 2 edges, one bin's left and right")
    for i in range(1, len(edges)):
        if edges[i] <= edges[i - 1]:
            raise fail(f"bins.edges[{i}]", edges[i], f"it must be greater than {edges[i - 1]!r}")
    payouts = _numbers(given.multipliers, "bins.multipliers", pays)
    if len(payouts) != len(edges) - 1:
        raise BoardError(
            f"bins.multipliers has {len(payouts)} values: {len(edges)} edges make "
            f"{len(edges) - 1} bins, and each needs one",
            field="bins.multipliers",
        )
    labels = _labels(given.labels, len(payouts))
    return Bins(number(given.y, "bins.y", height), edges, payouts, labels)


def _labels(value: Any, count: int) -> tuple[Label | None, ...]:
    """Return `value` as one label or None for each bin; empty if all are None."""
    labels = items(value, "bins.labels", MAX_BINS)
    if labels and len(labels) != count:
        raise BoardError(
            f"bins.labels has {len(labels)} values: there are {count} bins, and each needs one, "
            "which may be null",
            field="bins.labels",
        )
    checked = checked_items(_label, labels, "bins.labels")
    return checked if any(label is not None for label in checked) else ()


def _label(value: Any, field: str) -> Label | None:
    if value is None:
        return None
    label = instance(value, Label, field)
    text = plain_text.normal(label.text)
    right = plain_text.fault(text, MAX_LABEL)
    if right is not None:
        raise fail(f"{field}.text", label.text, f"it must be {right}")
    colour: Any = label.colour
    if colour is not None and not (isinstance(colour, str) and re.fullmatch(COLOUR, colour)):
        raise fail(f"{field}.colour", colour, "it must be # and six digits of 0-9 and a-f")
    return Label(text, colour)


def _numbers(value: Any, field: str, kind: Field) -> tuple[float, ...]:
    return tuple(
        number(v, f"{field}[{i}]", kind) for i, v in enumerate(items(value, field, kind.most))
    )


CHECKS: Final[Mapping[str, Callable[[Any], Any]]] = {
    "name": name,
    **{
        each.name: partial(number, field=each.name, kind=each)
        for each in FORM["board"]
        if each.default is not None
    },
    "ball": partial(part, field="ball", kind=BallSpec, fields=FORM["ball"]),
    "pegs": pegs,
    "peg_material": partial(material, field="peg_material"),
    "walls": walls,
    "wall_material": partial(material, field="wall_material"),
    "bins": bins,
    "drop": drop_zone,
}
"""The check of each field of a board, in the order in which errors list their faults."""
