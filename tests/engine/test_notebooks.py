"""What a notebook shows: valid SVG drawings, and pictures by an installed painter."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from plinko.app.render.notebook import png
from plinko.engine import Board, drop, drop_many, notebooks
from plinko.engine.board.parts import Bins
from tests.engine.multibody.static_scenes import place
from tests.repository.test_repository import PROJECT

BOARD = Board.preset("triangle-8")
SVG = "{http://www.w3.org/2000/svg}"
PNG_MAGIC = b"\x89PNG\r\n\x1a\n"


def shown() -> dict[str, Any]:
    return {
        "board": BOARD,
        "drop": drop(BOARD, 1),
        "batch": drop_many(BOARD, range(50)),
        "empty batch": drop_many(BOARD, []),
        "galton": drop_many("galton", range(50)),
    }


@pytest.mark.parametrize("name", shown())
def test_a_notebook_shows_a_drawing_with_its_caption(name: str) -> None:
    value = shown()[name]
    html = value._repr_html_()
    figure = ElementTree.fromstring(html)
    assert figure.find(f"{SVG}svg") is not None
    caption = figure.find("figcaption/code")
    assert caption is not None
    assert caption.text == repr(value)
    assert len(html) < 20_000


def test_a_drawing_has_every_peg_and_bin() -> None:
    board = ElementTree.fromstring(BOARD._repr_html_())
    pegs, _, bins = (path.attrib["d"] for path in board.iter(f"{SVG}path"))
    assert pegs.count("M") == len(BOARD.pegs)
    assert bins.count("v") == len(BOARD.bins.edges)


def test_the_path_of_a_drop_is_drawn_from_its_start_to_its_end() -> None:
    one = drop(BOARD, 1)
    (line,) = ElementTree.fromstring(one._repr_html_()).iter(f"{SVG}polyline")
    points = [tuple(map(float, point.split(","))) for point in line.attrib["points"].split()]
    assert points[0] == (round(100 * one.x_start, 1), 0.0)
    assert points[-1] == (round(100 * one.x_end, 1), round(100 * BOARD.bins.y, 1))
    for row in one.impacts:
        assert (round(100 * row["x"], 1), round(100 * row["y"], 1)) in points


def test_columns_are_as_high_as_the_counts() -> None:
    many = drop_many(BOARD, range(200))
    columns = [*ElementTree.fromstring(many._repr_html_()).iter(f"{SVG}rect")]
    heights = [float(column.attrib["height"]) for column in columns]
    top = max(many.histogram)
    assert heights == pytest.approx([160.0 * n / top for n in many.histogram], abs=0.05)


def test_a_boards_name_is_text_and_no_markup() -> None:
    form = BOARD.to_dict() | {"name": "<script>alert(1)</script>&"}
    html = Board.from_json(form)._repr_html_()
    assert "<script" not in html
    assert ElementTree.fromstring(html).find("figcaption") is not None


def test_a_board_as_large_as_may_be_is_drawn() -> None:
    huge = place(radius=1.0, bins=Bins(1e6, (-1e6, 1e6), (1.0,)))
    assert "e+" not in huge._repr_html_()


@pytest.mark.parametrize("width", [0.01, 0.1, 1000.0])
def test_a_drawing_has_the_same_strokes_whatever_the_board_s_size(width: float) -> None:
    form = {
        "width": width,
        "height": width,
        "ball": {"radius": 0.02 * width},
        "pegs": [{"x": 0.0, "y": 0.5 * width, "radius": 0.05 * width}],
        "bins": {"edges": [-0.5 * width, 0.5 * width]},
        "drop": {"jitter": 0.1 * width, "y": 0.0},
        "gravity": width,
    }
    (svg,) = ElementTree.fromstring(Board.from_json(form)._repr_html_()).iter(f"{SVG}svg")
    units = float(svg.attrib["viewBox"].split()[2])
    assert 600.0 <= units <= 800.0
    pegs, walls, _ = svg.iter(f"{SVG}path")
    assert float(pegs.attrib["d"].split("a")[1].split()[0]) == pytest.approx(0.05 * units, abs=0.1)
    assert walls.attrib["stroke-width"] == "2"


@pytest.mark.parametrize("name", ["board", "drop", "batch", "empty batch"])
def test_a_picture_is_a_png(name: str) -> None:
    assert png(shown()[name]).startswith(PNG_MAGIC)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path for a package with a painter; no other painter is found."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    notebooks._painter.cache_clear()
    yield tmp_path
    notebooks._painter.cache_clear()


def test_a_picture_is_drawn_by_whoever_is_installed_for_it(installed: Path) -> None:
    named = PROJECT["project"]["entry-points"][notebooks.PICTURES][notebooks.PNG]
    info = installed / "plinko_sim-9.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plinko-sim\nVersion: 9\n")
    (info / "entry_points.txt").write_text(f"[{notebooks.PICTURES}]\n{notebooks.PNG} = {named}\n")
    one, many = drop(BOARD, 1), drop_many(BOARD, range(9))
    assert BOARD._repr_png_() == png(BOARD)
    assert one._repr_png_() == png(one)
    assert many._repr_png_() == png(many)


def test_where_nobody_is_installed_there_is_no_picture(
    installed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: ())
    assert BOARD._repr_png_() is None
