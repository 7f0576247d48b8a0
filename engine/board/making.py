"""Ways to make a board without JSON: a triangle of any size, changes to a board, polygons."""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from itertools import pairwise
from typing import Any, Final

from plinko.engine.board import form, json_form, payouts, presets, values
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.parts import Wall

ROWS: Final = range(4, 21)
"""Allowed rows of a triangle. With fewer a ball wedges at a wall; with more pegs are too small."""


def triangle_fields(rows: int, risk: str) -> BoardFields:
    """Return the fields of a triangle: of the preset for 8 to 16 rows, otherwise of one like it.

    Other triangles have the physics of the nearest preset, and each bin returns the stake, because
    no payout table was solved for them. `plinko.engine.payouts` can solve one.
    """
    if rows not in ROWS:
        raise values.fail("rows", rows, f"it must be an integer from {ROWS[0]} to {ROWS[-1]}")
    if risk not in payouts.RISKS:
        raise values.fail("risk", risk, "it must be low, medium or high")
    if rows in payouts.ROWS:
        suffix = "" if risk == "medium" else f"-{risk}"
        return presets.preset_fields(f"triangle-{rows}{suffix}")
    nearest = min(payouts.ROWS, key=lambda known: abs(known - rows))
    tuning = presets.TUNING[f"triangle-{nearest}"]
    return presets.triangle(f"triangle-{rows}", rows, (1.0,) * (rows + 1), tuning)


def replaced(board: BoardFields, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return all fields of `board` with these changes; a mapping changes some fields of a part.

    Raises BoardError for an unknown field.
    """
    faults = Faults()
    json_form.check_known(changes, form.names("board"), "", faults)
    faults.end()
    result = {name: getattr(board, name) for name in form.names("board")}
    for name, change in changes.items():
        part = result[name]
        if isinstance(change, Mapping) and is_dataclass(part):
            names = tuple(field.name for field in fields(part))
            json_form.check_known(change, names, f"{name}.", faults)
            faults.end()
            result[name] = replace(part, **change)  # type: ignore[type-var]
        else:
            result[name] = change
    return result


def polygon(corners: Iterable[tuple[float, float]]) -> tuple[Wall, ...]:
    """Return the walls of a closed polygon with these corners (x, y) in m.

    To add it to a board: `board.replace(walls=[*board.walls, *polygon([(0, 1), (1, 2), …])])`.
    """
    points = list(corners)
    if len(points) < 3:
        raise values.fail("corners", points, "a polygon needs at least 3 corners")
    return tuple(Wall(*a, *b) for a, b in pairwise([*points, points[0]]))
