"""Boards without their JSON: a triangle of any size, a board with some parts replaced, polygons."""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from itertools import pairwise
from typing import Any, Final

from engine.board import payouts, presets, values
from engine.board.fields import BoardFields
from engine.board.parts import Wall
from engine.errors import BoardError

ROWS: Final = range(4, 21)
"""Rows of a triangle: on fewer a ball wedges beside the wall, more leave pegs next to no size."""


def triangle_fields(rows: int, risk: str) -> BoardFields:
    """Of the triangle with so many rows: a preset for 8 to 16 rows, else one shaped like it.

    The others have the physics of the nearest preset, and each bin pays its stake back: nobody has
    counted where their balls land (`engine.payouts` does).
    """
    if rows not in ROWS:
        raise values.fail("rows", rows, f"it must be an integer from {ROWS[0]} to {ROWS[-1]}")
    if risk not in payouts.HALF_TABLES:
        raise values.fail("risk", risk, f"it must be one of {', '.join(payouts.HALF_TABLES)}")
    if rows in payouts.ROWS:
        suffix = "" if risk == "medium" else f"-{risk}"
        return presets.preset_fields(f"triangle-{rows}{suffix}")
    nearest = min(payouts.ROWS, key=lambda known: abs(known - rows))
    tuning = presets.TUNING[f"triangle-{nearest}"]
    return presets.triangle(f"triangle-{rows}", rows, (1.0,) * (rows + 1), tuning)


def replaced(board: BoardFields, changes: Mapping[str, Any]) -> dict[str, Any]:
    """All fields of `board` with these changes. A mapping changes some fields of a part.

    Raises BoardError naming a field that there is not.
    """
    result = {field.name: getattr(board, field.name) for field in fields(BoardFields)}
    _known(result, changes, "")
    for name, change in changes.items():
        part = result[name]
        if isinstance(change, Mapping) and is_dataclass(part):
            _known({field.name for field in fields(part)}, change, f"{name}.")
            result[name] = replace(part, **change)  # type: ignore[type-var]
        else:
            result[name] = change
    return result


def _known(names: Iterable[str], changes: Mapping[str, Any], prefix: str) -> None:
    for name in changes:
        if name not in names:
            whole = prefix.rstrip(".") or "a board"
            path = f"{prefix}{name}"
            raise BoardError(f"{path} is unknown: {whole} has {', '.join(names)}", field=path)


def polygon(corners: Iterable[tuple[float, float]]) -> tuple[Wall, ...]:
    """The walls of a polygon with these corners (x, y), in m: from each to the next and back.

    An obstacle for a board: `board.replace(walls=[*board.walls, *polygon([(0, 1), (1, 2), …])])`.
    """
    points = list(corners)
    if len(points) < 3:
        raise values.fail("corners", points, "a polygon needs at least 3 corners")
    return tuple(Wall(*a, *b) for a, b in pairwise([*points, points[0]]))
