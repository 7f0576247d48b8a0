"""The error for an invalid value names its path, the value, and the rule."""

import json
import math
from itertools import product
from pathlib import Path

import pytest

from plinko.engine.board.form import MAX_BINS, field_of
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, Peg
from plinko.engine.errors import BoardError, shorten
from tests.engine.board.forms import EXAMPLE, at, box, changed, dotted, leaves

Path_ = tuple[str | int, ...]

NO_NUMBERS: list[object] = [True, False, "1.0", None, [1.0], {}, 1j]
NUMBERS = [path for path in leaves(EXAMPLE) if path != ("name",)]


def refusal(source: object) -> BoardError:
    """The error that `source` raises."""
    with pytest.raises(BoardError) as caught:
        Board.from_json(source)  # type: ignore[arg-type]
    return caught.value


def test_every_number_must_be_a_finite_number_and_true_is_not() -> None:
    for path in NUMBERS:
        name = dotted(path)
        for value in (math.nan, math.inf, -math.inf):
            form = changed(EXAMPLE, path, value)
            for source, why in (
                (form, f"{name} is {value!r}: it must be finite"),
                (json.dumps(form), f"{name}: {json.dumps(value)} is not a JSON number"),
            ):
                error = refusal(source)
                assert error.field == name
                assert str(error).startswith(why)
        for wrong in NO_NUMBERS:
            error = refusal(changed(EXAMPLE, path, wrong))
            assert error.field == name
            assert str(error) == f"{name} is {wrong!r}: it must be a number"


@pytest.mark.parametrize("value", [1.0001e6, -1.0001e6, 10**400], ids=["far", "-far", "huge"])
@pytest.mark.parametrize("path", [("pegs", 0, "x"), ("walls", 0, "y2"), ("bins", "edges", 1)])
def test_coordinates_stay_within_a_million_metres(path: Path_, value: float) -> None:
    error = refusal(changed(EXAMPLE, path, value))
    assert error.field == dotted(path)
    assert "1e+06" in str(error)


@pytest.mark.parametrize(
    ("path", "value", "rule"),
    [
        (("ball", "radius"), 0.0, "greater than 0"),
        (("ball", "radius"), -0.08, "greater than 0"),
        (("ball", "radius"), 10001.0, "to 10000 m"),
        (("pegs", 0, "radius"), 0, "greater than 0"),
        (("pegs", 0, "radius"), -0.05, "greater than 0"),
        (("ball", "density"), 0.0, "greater than 0"),
        (("ball", "density"), 1e10, "to 1e+09"),
        (("ball", "restitution"), 1.0000001, "from 0 to 1"),
        (("ball", "restitution"), -0.1, "from 0 to 1"),
        (("peg_material", "restitution"), 2, "from 0 to 1"),
        (("wall_material", "restitution"), -1, "from 0 to 1"),
        (("ball", "friction"), -0.01, "from 0 to 10"),
        (("peg_material", "friction"), 10.5, "from 0 to 10"),
        (("wall_material", "friction"), -1, "from 0 to 10"),
        (("drag",), -1e-9, "from 0 to 1000"),
        (("drag",), 1001, "from 0 to 1000"),
        (("gravity",), 0.0, "no ball would ever reach a bin"),
        (("gravity",), -9.81, "no ball would ever reach a bin"),
        (("gravity",), 10001, "to 10000"),
        (("width",), 0, "greater than 0"),
        (("height",), -6.0, "greater than 0"),
        (("bins", "edges", 1), -4.0, "greater than -4.0"),
        (("bins", "edges", 2), -3.75, "greater than -3.5"),
        (("bins", "multipliers", 1), -0.5, "from 0"),
        (("drop", "jitter"), -0.25, "from 0"),
        (("name",), "", "1 to 100 printable"),
        (("name",), "x" * 101, "1 to 100 printable"),
        (("name",), "two\nlines", "1 to 100 printable"),
        (("name",), "\ud800", "1 to 100 printable"),
        (("name",), 7, "1 to 100 printable"),
    ],
    ids=str,
)
def test_a_value_out_of_range_is_named_with_what_would_be_right(
    path: Path_, value: object, rule: str
) -> None:
    error = refusal(changed(EXAMPLE, path, value))
    assert error.field == dotted(path)
    assert str(error).startswith(f"{dotted(path)} is {shorten(value)}")
    assert rule in str(error)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("ball", "restitution"), 0),
        (("ball", "restitution"), 1),
        (("ball", "friction"), 10),
        (("drag",), 1000),
        (("gravity",), 1e-6),
        (("bins", "multipliers", 0), 0),
    ],
    ids=str,
)
def test_the_ends_of_a_range_are_allowed(path: Path_, value: float) -> None:
    assert at(Board.kept(changed(EXAMPLE, path, value)).to_dict(), path) == value


def test_each_bin_needs_one_multiplier() -> None:
    error = refusal(changed(EXAMPLE, ("bins", "multipliers"), [1.0, 2.0, 3.0]))
    assert error.field == "bins.multipliers"
    assert "has 3 values" in str(error)
    assert "3 edges make 2 bins" in str(error)
    assert refusal({"bins": {"multipliers": []}}).field == "bins.multipliers"
    assert refusal({"bins": {"edges": [1.0]}}).field == "bins.edges"


@pytest.mark.parametrize("x2", [-4.0, -4.0 + 1e-9])
def test_a_wall_has_a_length(x2: float) -> None:
    wall = {"x1": -4.0, "y1": 1.0, "x2": x2, "y2": 1.0}
    error = refusal(changed(EXAMPLE, ("walls", 0), wall))
    assert error.field == "walls[0]"
    assert "has no length" in str(error)
    assert "(-4.0, 1.0)" in str(error)


@pytest.mark.parametrize(
    ("path", "field"),
    [
        (("colour",), "colour"),
        (("ball", "mass"), "ball.mass"),
        (("pegs", 0, "r"), "pegs[0].r"),
        (("peg_material", "bounce"), "peg_material.bounce"),
        (("walls", 0, "x3"), "walls[0].x3"),
        (("bins", "edge"), "bins.edge"),
        (("drop", "jiter"), "drop.jiter"),
    ],
)
def test_an_unknown_key_is_named_so_that_a_typo_cannot_pass(path: Path_, field: str) -> None:
    error = refusal(changed(EXAMPLE, path, 1.0))
    assert error.field == field
    assert f"{field} is unknown" in str(error)


@pytest.mark.parametrize("path", [("pegs", 0, "radius"), ("walls", 0, "y1")], ids=dotted)
def test_pegs_and_walls_must_be_whole(path: Path_) -> None:
    form = changed(EXAMPLE, path, 1.0)
    del at(form, path[:-1])[path[-1]]
    error = refusal(form)
    assert error.field == dotted(path)
    assert "is missing" in str(error)


PARTS = [(name,) for name in ("ball", "peg_material", "wall_material", "bins", "drop")]
LISTS = [("pegs",), ("walls",), ("bins", "edges"), ("bins", "multipliers"), ("drop", "slots")]


@pytest.mark.parametrize(
    ("kind", "paths", "wrong"),
    [
        ("an object", PARTS, (None, 3, "x", [1])),
        ("a list", LISTS, (None, 3, "abc", {"0": 1})),
    ],
)
def test_a_part_must_be_an_object_and_a_list_a_list(
    kind: str, paths: list[Path_], wrong: tuple[object, ...]
) -> None:
    for path, value in product(paths, wrong):
        error = refusal(changed(EXAMPLE, path, value))
        assert error.field == dotted(path)
        assert str(error) == f"{dotted(path)} is {value!r}: it must be {kind}"


def test_the_items_of_a_list_of_parts_must_be_objects() -> None:
    assert refusal({"pegs": [1]}).field == "pegs[0]"
    assert refusal({"walls": [[0, 0, 1, 1]]}).field == "walls[0]"


@pytest.mark.parametrize(
    ("path", "item", "limit"),
    [
        (("pegs",), {"x": 0.0, "y": 3.0, "radius": 0.1}, field_of("board", "pegs").most),
        (("walls",), {"x1": 0.0, "y1": 3.0, "x2": 1.0, "y2": 3.0}, field_of("board", "walls").most),
        (("bins", "edges"), 0.0, MAX_BINS + 1),
        (("bins", "multipliers"), 1.0, MAX_BINS),
        (("drop", "slots"), 0.0, field_of("drop", "slots").most),
    ],
    ids=str,
)
def test_lists_have_a_limit_that_the_error_tells(path: Path_, item: object, limit: int) -> None:
    error = refusal(changed(EXAMPLE, path, [item] * (limit + 1)))
    assert error.field == dotted(path)
    assert f"has {limit + 1} items: at most {limit} are allowed" in str(error)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"width": 8.0', "the board is not JSON"),
        ("{" + '"a":' * 3 + "1}", "the board is not JSON"),
        ('{"ball": {"radius": 0.1, "radius": 0.1}}', "ball.radius: the key is given twice"),
        ("{" + " " * 16_000_000 + "}", "at most 16000000"),
    ],
    ids=["cut short", "no value", "twice", "long"],
)
def test_text_that_is_not_one_plain_object_is_refused(text: str, reason: str) -> None:
    assert reason in str(refusal(text))


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    assert str(refusal("missing.json")).startswith("board is 'missing.json': the file cannot be")
    binary = tmp_path / "binary.json"
    binary.write_bytes(b"\x89PNG")
    assert "not UTF-8" in str(refusal(binary))
    binary.write_bytes(b"\xff\xfe\x00")
    assert "not UTF-16" in str(refusal(binary))
    listing = tmp_path / "list.json"
    listing.write_text("[1, 2]", encoding="utf-8")
    assert "must be an object" in str(refusal(listing))
    assert "cannot be read" in str(refusal(tmp_path))
    assert "cannot be read" in str(refusal("a\0b.json"))


@pytest.mark.parametrize("source", [None, 5, 1.5, ["{}"], b"{}"], ids=repr)
def test_an_invalid_source_is_refused(source: object) -> None:
    assert refusal(source).field == "board"


def test_parts_of_a_wrong_class_are_refused_in_code() -> None:
    bins = Bins(6.0, (-4.0, 4.0), (1.0,))
    with pytest.raises(BoardError, match=r"ball is .* must be a BallSpec") as caught:
        Board(bins=bins, ball=0.1)  # type: ignore[arg-type]
    assert caught.value.field == "ball"
    with pytest.raises(BoardError, match=r"pegs\[0\] is .* must be a Peg"):
        Board(bins=bins, pegs=((0.0, 1.0, 0.1),))  # type: ignore[arg-type]
    with pytest.raises(BoardError, match=r"pegs\[1\]\.radius is -1"):
        Board(bins=bins, pegs=(Peg(0, 1, 0.1), Peg(0, 2, -1)))
    with pytest.raises(BoardError, match=r"ball\.radius is 0"):
        Board(bins=bins, ball=BallSpec(radius=0))


def test_errors_stay_short_however_long_the_value() -> None:
    assert len(str(refusal(changed(box(), ("name",), "n" * 10_000)))) < 200
    assert len(str(refusal({"k" * 10_000: 1}))) < 400
