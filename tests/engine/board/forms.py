"""Boards in JSON form for the board tests: an example, an empty box, and random boards."""

import copy
import math
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

Form = dict[str, Any]

EXAMPLE: Form = {
    "name": "example",
    "width": 8.0,
    "height": 6.0,
    "gravity": 9.81,
    "drag": 0.0,
    "ball": {"radius": 0.08, "density": 1.0, "restitution": 0.6, "friction": 0.0},
    "pegs": [{"x": 0.0, "y": 0.0, "radius": 0.05}],
    "peg_material": {"restitution": 0.6, "friction": 0.0},
    "walls": [{"x1": -4.0, "y1": -1.0, "x2": -4.0, "y2": 6.0}],
    "wall_material": {"restitution": 0.6, "friction": 0.0},
    "bins": {"y": 5.196, "edges": [-4.0, -3.5, 4.0], "multipliers": [1.0, 2.0]},
    "drop": {"x": 0.0, "y": -0.5, "jitter": 0.25},
}
"""The example of the design document, verbatim."""

SIDES = [
    {"x1": -4.0, "y1": -1.0, "x2": -4.0, "y2": 6.0},
    {"x1": 4.0, "y1": -1.0, "x2": 4.0, "y2": 6.0},
]
"""Upright walls at x = -4 and 4, from above the start to the bins of `box`."""


def changed(form: Form, path: tuple[str | int, ...], value: object) -> Form:
    """A copy of `form` with `value` at `path`."""
    result = copy.deepcopy(form)
    place: Any = result
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return result


def leaves(form: object, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Paths of all leaf values in `form`: those that are neither lists nor objects."""
    if isinstance(form, dict):
        for key, value in form.items():
            yield from leaves(value, (*path, key))
    elif isinstance(form, list):
        for i, value in enumerate(form):
            yield from leaves(value, (*path, i))
    else:
        yield path


def at(form: Form, path: tuple[str | int, ...]) -> Any:
    """The value at `path` of `form`."""
    place: Any = form
    for key in path:
        place = place[key]
    return place


def dotted(path: tuple[str | int, ...]) -> str:
    """`path` in the spelling of error messages, such as pegs[3].radius."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return text.removeprefix(".")


def box(
    pegs: list[tuple[float, float, float]] | None = None,
    walls: list[tuple[float, float, float, float]] | None = None,
    radius: float = 0.1,
    sides: bool = True,
) -> Form:
    """A box 8 m wide and 6 m deep with a ball started at (0, 0); pegs (x, y, radius)."""
    inside = [dict(zip(("x1", "y1", "x2", "y2"), w, strict=True)) for w in walls or []]
    return {
        "ball": {"radius": radius},
        "pegs": [{"x": x, "y": y, "radius": r} for x, y, r in pegs or []],
        "walls": (copy.deepcopy(SIDES) if sides else []) + inside,
        "bins": {"y": 6.0, "edges": [-4.0, 0.0, 4.0]},
    }


def mirrored(form: Form) -> Form:
    """`form` with left and right exchanged."""
    result = copy.deepcopy(form)
    for peg in result.get("pegs", []):
        peg["x"] = -peg["x"]
    for wall in result.get("walls", []):
        wall["x1"], wall["x2"] = -wall["x1"], -wall["x2"]
    bins = result["bins"]
    bins["edges"] = [-x for x in reversed(bins["edges"])]
    for name in {"multipliers", "labels"} & set(bins):
        bins[name] = bins[name][::-1]
    if "drop" in result:
        result["drop"]["x"] = -result["drop"].get("x", 0.0)
        result["drop"]["slots"] = [-x for x in reversed(result["drop"].get("slots", []))]
    return result


def _between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


def _labels(count: int) -> st.SearchStrategy[Form]:
    """No labels at all, or for each bin a label or None."""
    text = st.text("aZäß9&<🎁日", min_size=1, max_size=40)
    colours = st.sampled_from(["#000000", "#ff0088"])
    label = st.fixed_dictionaries({"text": text}, optional={"colour": colours})
    several = st.lists(st.none() | label, min_size=count, max_size=count).filter(any)
    return st.just({}) | st.fixed_dictionaries({"labels": several})


@st.composite
def valid_forms(draw: st.DrawFn) -> Form:
    """Playable boards: sparse random pegs in a walled box, with every value random."""
    radius = draw(_between(0.05, 0.2))
    cell = 4.0 * radius + 0.5
    columns = int(6.0 / cell)
    rows = int(4.0 / cell)
    cells = draw(st.sets(st.tuples(st.integers(0, columns - 1), st.integers(0, rows - 1))))
    pegs = []
    for column, row in sorted(cells):
        peg_radius = draw(_between(0.01, 0.08))
        x = -3.0 + (column + 0.5) * cell + draw(_between(-0.1, 0.1))
        y = 1.0 + (row + 0.5) * cell + draw(_between(-0.1, 0.1))
        pegs.append({"x": x, "y": y, "radius": peg_radius})
    inner = sorted(draw(st.sets(_between(-3.9, 3.9), max_size=6)))
    edges = [-4.0, *inner, 4.0]
    count = len(edges) - 1
    material = st.fixed_dictionaries(
        {"restitution": _between(0.0, 1.0), "friction": _between(0.0, 2.0)}
    )
    starts = _between(-3.0, 3.0)
    return {
        "name": draw(st.text(st.characters(categories=("L", "N", "P", "S")), min_size=1)),
        "width": draw(_between(1.0, 10.0)),
        "height": draw(_between(1.0, 10.0)),
        "gravity": draw(_between(0.1, 100.0)),
        "drag": draw(_between(0.0, 10.0)),
        "ball": {"radius": radius, "density": draw(_between(0.01, 1e4)), **draw(material)},
        "pegs": pegs,
        "peg_material": draw(material),
        "walls": copy.deepcopy(SIDES),
        "wall_material": draw(material),
        "bins": {
            "y": 6.0,
            "edges": edges,
            "multipliers": draw(st.lists(_between(0.0, 1e3), min_size=count, max_size=count)),
            **draw(_labels(count)),
        },
        "drop": {
            "x": draw(_between(-1.0, 1.0)),
            "y": draw(_between(-0.5, 0.5)),
            "jitter": draw(_between(0.0, 1.0)),
            "slots": draw(st.lists(starts, max_size=4)),
            "reach": draw(_between(0.01, 1.0)),
        },
    }


@st.composite
def wild_forms(draw: st.DrawFn) -> Form:
    """Boxes with a few large pegs and walls at random places, playable or not, for a ball of
    radius 0.3."""
    pegs: list[tuple[float, float, float]] = []
    for _ in range(draw(st.integers(0, 12))):
        x, y, r = draw(_between(-4.0, 4.0)), draw(_between(0.2, 6.0)), draw(_between(0.05, 0.8))
        if all(math.hypot(x - px, y - py) > r + pr for px, py, pr in pegs):
            pegs.append((x, y, r))
    walls = [
        (x, y, x + draw(_between(0.1, 2.0)), y + draw(_between(-2.0, 2.0)))
        for x, y in draw(st.lists(st.tuples(_between(-4.0, 4.0), _between(-0.5, 6.5)), max_size=4))
    ]
    return box(pegs, walls, radius=0.3, sides=draw(st.booleans()))
