"""Tables of boards and scenes in the documentation agree with the code."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from plinko.app.rooms.touching.scene import BALLS, DEFAULTS, SIDE, SPEED
from plinko.app.rooms.touching.values import BALL, SETTINGS
from plinko.engine import Board, BoardError
from plinko.engine.board.form import names
from tools import board_form

DOCS = Path(__file__).parents[2] / "docs"

Row = dict[str, str]


def rows(page: str, first: str) -> list[Row]:
    """The rows of the table whose first heading is `first`, by heading."""
    text = (DOCS / page).read_text(encoding="utf-8")
    lines = text[text.index(f"| {first} |") :].split("\n\n")[0].splitlines()
    table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [dict(zip(table[0], row, strict=True)) for row in table[2:]]


def named(row: Row, heading: str) -> list[str]:
    return re.findall(r"`([^`]+)`", row[heading])


FIELDS = rows("boards.md", "field")

EXAMPLE: dict[str, Any] = json.loads(
    re.findall(r"```json\n(.*?)```", (DOCS / "boards.md").read_text(encoding="utf-8"), re.DOTALL)[0]
)


def test_the_pages_copy_of_the_table_is_the_engine_s() -> None:
    assert board_form.FILE.read_text(encoding="utf-8") == board_form.script()


def test_every_field_of_a_board_has_a_row_and_no_other_has() -> None:
    parts = {name: names(name) for name in ("ball", "bins", "drop")}
    parts |= dict.fromkeys(("peg_material", "wall_material"), names("material"))
    lists = {"pegs": names("peg"), "walls": names("wall")}
    expected = {name for name in names("board") if name not in parts}
    expected |= {f"{part}.{name}" for part, keys in parts.items() for name in keys}
    expected |= {f"{part}[].{name}" for part, keys in lists.items() for name in keys}
    assert {name for row in FIELDS for name in named(row, "field")} == expected


def test_the_example_is_a_board_as_it_would_be_written() -> None:
    assert Board.from_json(EXAMPLE).to_dict() == EXAMPLE


def with_value(path: str, value: float) -> dict[str, Any]:
    """The example board with one value replaced."""
    form = json.loads(json.dumps(EXAMPLE))
    part = form
    *outer, last = re.findall(r"[\w]+", path)
    for name in outer:
        part = part[name]
        part = part[0] if isinstance(part, list) else part
    part[last] = [value] * len(part[last]) if isinstance(part.get(last), list) else value
    if last == "slots":
        part[last] = [value]
    return form  # type: ignore[no-any-return]


def complaint(form: dict[str, Any]) -> tuple[str, str]:
    """Field and message of a board's error; both are empty for a valid board."""
    try:
        Board.from_json(form)
    except BoardError as error:
        return error.field, str(error)
    return "", ""


OUT_OF_RANGE = re.compile(r"must be (greater than 0, )?from")
NUMBERS = [
    (name, float(row["from"]), float(row["to"]))
    for row in FIELDS
    if row["unit"] not in ("characters", "pegs", "walls")
    for name in named(row, "field")
]


@pytest.mark.parametrize(("name", "low", "high"), NUMBERS)
def test_limits_are_what_the_page_says(name: str, low: float, high: float) -> None:
    """A number at its limit is in range, even if the board is not playable; beyond it is not."""
    path = name.replace("[]", "[0]")
    for value, outside in ((low, low - abs(low) * 1e-9 - 1e-9), (high, high * (1 + 1e-9))):
        field, says = complaint(with_value(name, value))
        assert not (field.startswith(path) and OUT_OF_RANGE.search(says)), says
        field, says = complaint(with_value(name, outside))
        assert field.startswith(path), name
        assert OUT_OF_RANGE.search(says), says


@pytest.mark.parametrize("row", [row for row in FIELDS if row["unit"] in ("pegs", "walls")])
def test_counts_are_what_the_page_says(row: Row) -> None:
    (name,) = named(row, "field")
    many = EXAMPLE | {name: [EXAMPLE[name][0]] * (int(row["to"]) + 1)}
    assert complaint(many) == (
        name,
        f"{name} has {int(row['to']) + 1} items: at most {row['to']} are allowed",
    )


def test_defaults_are_what_the_page_says() -> None:
    empty = Board.from_json({}).to_dict()
    for row in FIELDS:
        if not re.fullmatch(r'[-\d.]+|`".*"`', row["default"]):
            continue
        for name in named(row, "field"):
            value: Any = empty
            for part in name.split("."):
                value = value.get(part, 0.0)
            assert value == json.loads(row["default"].strip("`")), name


# Scenes.


@pytest.mark.parametrize("scene", DEFAULTS)
def test_parameters_of_scenes_are_what_the_page_says(scene: str) -> None:
    known = {"balls": BALLS, "width": SIDE, "height": SIDE, "speed": SPEED, "radii": BALL["radius"]}
    ranges = {**SETTINGS, **{name: BALL[name] for name in BALL if name != "radius"}, **known}
    found = {}
    for row in rows("api.md", "parameter"):
        names = named(row, "parameter")
        for number, name in enumerate(names):
            if name in ranges:
                limits = float(row["from"]), float(row["to"])
                assert limits == (ranges[name].low, ranges[name].high), name
                assert row["unit"] in (ranges[name].unit, ""), name
            if row[scene]:
                text = row[scene].strip("`")
                if len(names) > 1:
                    text = text.split(", ")[number]
                found[name] = 1 / 60 if text == "1/60" else json.loads(text)
    assert found == DEFAULTS[scene]
