"""The JSON form of a board: reads it strictly, fills in omitted fields, writes it.

An unknown key, a duplicate key and a value of the wrong type are errors that name their path.
`Board` itself checks the ranges.

Defaults: an omitted part has the defaults of its class. Without `bins.edges` the bins divide the
width equally; without `bins.multipliers` each returns the stake; without `bins.y` they are at
`height`. Without `walls` there are two: at the outer edges of the bins, from above the start down
to the bins.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Final, TypeVar

from plinko.engine import json_text
from plinko.engine.board import values
from plinko.engine.board.faults import Faults, checked_items
from plinko.engine.board.fields import DEFAULT_HEIGHT, DEFAULT_WIDTH, BoardFields
from plinko.engine.board.form import MAX_BINS, field_of, names
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Label, Peg, Wall
from plinko.engine.errors import BoardError, JsonSyntaxError, JsonValueError

MAX_TEXT: Final = 16_000_000
"""Characters; three times as many as the largest valid board needs."""

LARGEST_FILE: Final = 4 * MAX_TEXT
"""Bytes; no encoding of Unicode has more than four for a character."""

PARTS: Final = ("ball", "peg_material", "wall_material", "drop", "bins")
"""Fields of a board that are objects in its JSON form."""

_PARTS: Final[Mapping[str, tuple[type[Any], tuple[str, ...]]]] = {
    "ball": (BallSpec, names("ball")),
    "peg_material": (Material, names("material")),
    "wall_material": (Material, names("material")),
    "drop": (DropZone, names("drop")),
}

Part = TypeVar("Part")


def load(source: str | os.PathLike[str] | Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the JSON object in `source`: JSON text (starts with `{`), a path, or an object.

    Raises BoardError if the text is not one JSON object or the file cannot be read.
    """
    if isinstance(source, Mapping):
        return source
    if isinstance(source, str) and source.lstrip().startswith("{"):
        return _parse(source)
    if isinstance(source, str | os.PathLike):
        return _parse(_read(source))
    raise values.fail("board", source, "it must be a path, JSON text or an object")


def _read(path: str | os.PathLike[str]) -> str:
    try:
        return json_text.read_text(path, LARGEST_FILE)
    except JsonSyntaxError as error:
        raise values.fail("board", os.fspath(path), f"the file is {error}") from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or str(error)
        wanted = f"the file cannot be read ({reason})"
        raise values.fail("board", os.fspath(path), wanted) from error


def _parse(text: str) -> Mapping[str, Any]:
    if len(text) > MAX_TEXT:
        raise BoardError(
            f"the board's JSON has {len(text)} characters: at most {MAX_TEXT} are allowed",
            field="board",
        )
    try:
        value = json_text.parse(text.removeprefix("\ufeff"))
    except JsonValueError as error:
        raise BoardError(str(error), field=error.field) from None
    except JsonSyntaxError as error:
        raise BoardError(f"the board is {error}", field="board") from None
    return _object(value, "board")


def fields(form: Mapping[str, Any], faults: Faults) -> dict[str, Any]:
    """Return the fields of a board for the JSON object `form`; their ranges are not checked yet.

    An invalid part is left out of the result and reported to `faults`.
    """
    check_known(form, names("board"), "", faults)
    result: dict[str, Any] = {}
    for key, (kind, keys) in _PARTS.items():
        result[key] = faults.take(_part, kind, form.get(key, {}), key, keys)
    result["pegs"] = faults.take(_parts, Peg, form.get("pegs", ()), "pegs", names("peg"))
    result["bins"] = faults.take(_bins, form)
    if "walls" in form:
        result["walls"] = faults.take(_parts, Wall, form["walls"], "walls", names("wall"))
    elif not faults.found:
        sides = (result["bins"], result["drop"], result["ball"])
        result["walls"] = faults.take(_side_walls, *sides)
    plain = ("name", "width", "height", "gravity", "drag")
    return {key: form[key] for key in plain if key in form} | {
        key: value for key, value in result.items() if value is not None
    }


def part(key: str, form: Mapping[str, Any], width: Any, height: Any) -> Any:
    """Return the part `key` of a board from its JSON form, such as `bins` from a dict."""
    if key == "bins":
        return _bins({"bins": form, "width": width, "height": height})
    kind, keys = _PARTS[key]
    return _part(kind, form, key, keys)


def _bins(form: Mapping[str, Any]) -> Bins:
    given = _object(form.get("bins", {}), "bins")
    faults = Faults()
    check_known(given, names("bins"), "bins.", faults)
    faults.end()
    width = values.CHECKS["width"](form.get("width", DEFAULT_WIDTH))
    height = values.CHECKS["height"](form.get("height", DEFAULT_HEIGHT))
    if "edges" in given:
        edges = given["edges"]
        count = len(values.items(edges, "bins.edges", MAX_BINS + 1)) - 1
    else:
        payouts = given.get("multipliers", (1.0,))
        count = max(1, len(values.items(payouts, "bins.multipliers", MAX_BINS)))
        edges = tuple(width * (2 * i - count) / (2 * count) for i in range(count + 1))
    payouts = given.get("multipliers", (1.0,) * count)
    return Bins(given.get("y", height), edges, payouts, _labels(given.get("labels", ())))


def _labels(value: Any) -> tuple[Label | None, ...]:
    def label(item: Any, path: str) -> Label | None:
        return None if item is None else _part(Label, item, path, names("label"), ("text",))

    items = values.items(value, "bins.labels", MAX_BINS)
    return checked_items(label, items, "bins.labels")


def _side_walls(bins: Bins, zone: DropZone, ball: BallSpec) -> tuple[Wall, ...]:
    bins = values.bins(bins)
    zone = values.drop_zone(zone)
    top = zone.y - 2.0 * values.number(ball.radius, "ball.radius", field_of("ball", "radius"))
    return tuple(Wall(x, top, x, bins.y) for x in (bins.edges[0], bins.edges[-1]) if top < bins.y)


def _object(value: Any, path: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise values.fail(path, value, "it must be an object")
    return value


def check_known(
    form: Mapping[str, Any], keys: tuple[str, ...], prefix: str, faults: Faults
) -> None:
    for key in form:
        if key not in keys and not faults.full:
            path = f"{prefix}{key}"[:100]
            message = f"{path} is unknown: {prefix.rstrip('.') or 'a board'} has {', '.join(keys)}"
            faults.add(path, message)


def _part(
    kind: type[Part],
    value: Any,
    path: str,
    keys: tuple[str, ...],
    required: tuple[str, ...] = (),
) -> Part:
    form = _object(value, path)
    faults = Faults()
    check_known(form, keys, f"{path}.", faults)
    for key in required:
        if key not in form:
            faults.add(f"{path}.{key}", f"{path}.{key} is missing")
    faults.end()
    return kind(**form)


def _parts(kind: type[Part], value: Any, path: str, keys: tuple[str, ...]) -> tuple[Part, ...]:
    items = values.items(value, path, field_of("board", path).most)
    return checked_items(lambda item, at: _part(kind, item, at, keys, keys), items, path)


def to_dict(board: BoardFields) -> dict[str, Any]:
    """Return the JSON form of `board`, without labels, `slots`, `reach` and `aim` if unused."""
    bins, zone = board.bins, board.drop
    pockets = {"y": bins.y, "edges": list(bins.edges), "multipliers": list(bins.multipliers)}
    if bins.labels:
        pockets["labels"] = [
            label and {"text": label.text} | ({"colour": label.colour} if label.colour else {})
            for label in bins.labels
        ]
    drop: dict[str, Any] = {"x": zone.x, "y": zone.y, "jitter": zone.jitter}
    if zone.slots:
        drop["slots"] = list(zone.slots)
    if zone.reach:
        drop["reach"] = zone.reach
    if zone.aim:
        drop["aim"] = zone.aim
    return {
        "name": board.name,
        "width": board.width,
        "height": board.height,
        "gravity": board.gravity,
        "drag": board.drag,
        "ball": {key: getattr(board.ball, key) for key in names("ball")},
        **surfaces_dict(board.pegs, board.peg_material, board.walls, board.wall_material),
        "bins": pockets,
        "drop": drop,
    }


def surfaces_dict(
    pegs: tuple[Peg, ...], peg_material: Material, walls: tuple[Wall, ...], wall_material: Material
) -> dict[str, Any]:
    """Return the JSON form of pegs and walls."""
    return {
        "pegs": [{"x": p.x, "y": p.y, "radius": p.radius} for p in pegs],
        "peg_material": asdict(peg_material),
        "walls": [{"x1": w.x1, "y1": w.y1, "x2": w.x2, "y2": w.y2} for w in walls],
        "wall_material": asdict(wall_material),
    }


def dumps(board: BoardFields) -> str:
    """Return the JSON text of `board`; each float is the shortest text that reads back the same."""
    return json.dumps(to_dict(board), allow_nan=False)
