"""Pictures of drops: they show where the ball went, in the page's colours, on any board."""

import io
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from app.errors import InvalidValueError
from app.render import drop_animation, drop_png
from app.render.animation import HOLD, TRAIL, TRAIL_STEP
from app.render.board import board_canvas
from app.render.canvas import Canvas
from app.render.path import points_at, sample_times
from app.render.view import MAX_ASPECT, View, lay_out
from app.settings import static_directory
from app.theme import THEMES, parse
from engine import Board, Drop, drop

Pixels = npt.NDArray[np.int64]


def decode(picture: bytes) -> Pixels:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB")).astype(np.int64)


def frames(animation: bytes) -> Iterator[tuple[Pixels, float]]:
    """Each frame and how long it stays, s."""
    with Image.open(io.BytesIO(animation)) as image:
        for number in range(getattr(image, "n_frames", 1)):
            image.seek(number)
            yield np.asarray(image.convert("RGB")).astype(np.int64), image.info["duration"] / 1000


def distance(pixels: Pixels, colour: tuple[int, int, int]) -> npt.NDArray[np.float64]:
    """How far each pixel is from a colour: 0 to 441."""
    apart: npt.NDArray[np.float64] = np.sqrt(((pixels - np.array(colour)) ** 2).sum(axis=-1))
    return apart


@pytest.fixture(scope="module")
def fall() -> Drop:
    return drop(Board.preset("triangle-8"), 42)


@pytest.fixture(scope="module")
def view(fall: Drop) -> View:
    return lay_out(fall.board, 760)


@pytest.fixture(scope="module")
def picture(fall: Drop) -> Pixels:
    return decode(drop_png(fall))


def empty_board(d: Drop, view: View) -> Pixels:
    return np.asarray(board_canvas(d.board, view, "light").image()).astype(np.int64)


# the still picture


def test_a_picture_is_as_wide_as_asked_and_holds_the_whole_board(
    fall: Drop, view: View, picture: Pixels
) -> None:
    assert picture.shape == (view.height, 760, 3)
    for x, y in ((fall.board.bins.edges[0], fall.board.bins.y), (0.0, fall.board.drop.y)):
        assert 0 <= view.px(x) < 760
        assert 0 <= view.py(y) < view.height


def test_the_same_drop_is_the_same_picture(fall: Drop) -> None:
    again = drop(Board.preset("triangle-8"), 42)
    assert drop_png(fall, 300) == drop_png(again, 300)
    assert drop_png(fall, 300) != drop_png(drop(fall.board, 43), 300)


def test_the_whole_path_is_drawn_and_nothing_far_from_it(
    fall: Drop, view: View, picture: Pixels
) -> None:
    changed = distance(picture, (0, 0, 0)) != distance(empty_board(fall, view), (0, 0, 0))
    points = points_at(fall, view, np.linspace(0.0, fall.duration, 500))
    inside = np.rint(points - 0.5).astype(int)
    assert changed[inside[:, 1], inside[:, 0]].mean() > 0.99
    rows, columns = np.nonzero(changed[: int(view.bin_top - 4)])  # the lit bin has a rim
    below = rows > view.start - 20  # the caption is above
    spots = np.column_stack([columns[below], rows[below]]) + 0.5
    nearest = np.sqrt(((spots[::7, None, :] - points[None]) ** 2).sum(axis=-1)).min(axis=1)
    assert nearest.max() < fall.board.ball.radius * view.scale + 8.0


def test_the_path_is_sampled_at_every_impact_and_finely(fall: Drop, view: View) -> None:
    times = sample_times(fall, view)
    assert set(fall.impacts["t"]) <= set(times)
    points = points_at(fall, view, times)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 2.0


def test_the_ball_is_at_its_start_and_in_its_bin(fall: Drop, view: View, picture: Pixels) -> None:
    """A little right of the band through its middle the ball is red."""
    ball = THEMES["light"]["ball"]
    radius = fall.board.ball.radius * view.scale
    for x, y in ((fall.x_start, fall.board.drop.y), (fall.x_end, fall.board.bins.y)):
        column, row = view.px(x), view.py(y)
        around = picture[int(row - radius) : int(row + radius), int(column - radius) :][
            :, : int(2 * radius)
        ]
        assert (distance(around, ball) < 60).mean() > 0.2


def test_bins_have_the_pages_colours_and_the_hit_one_a_bright_rim(
    fall: Drop, view: View, picture: Pixels
) -> None:
    data = json.loads((static_directory() / "theme.json").read_text(encoding="utf-8"))
    row = round(view.bin_top + 0.9 * view.bin_height)
    for number, score in enumerate(fall.board.bins.multipliers):
        fill = [step["fill"] for step in data["payout"] if score >= step["from"]][-1]
        middle = 0.5 * sum(fall.board.bins.edges[number : number + 2])
        assert tuple(picture[row, round(view.px(middle))]) == parse(fill)
    assert fall.bin is not None
    flash = parse(data["light"]["flash"])
    for number in range(fall.board.bins.count):
        edges = [round(view.px(x)) for x in fall.board.bins.edges[number : number + 2]]
        rim = distance(picture[row, edges[0] : edges[1]], flash) < 10
        assert bool(rim.sum() >= 4) == (number == fall.bin)


def test_contacts_are_marked_where_ball_and_peg_touch(
    fall: Drop, view: View, picture: Pixels
) -> None:
    hits = fall.impacts[fall.impacts["kind"] == 0]
    assert len(hits) > 3
    for hit in hits:
        peg = fall.board.pegs[hit["index"]]
        gap = math.hypot(peg.x - hit["x"], peg.y - hit["y"])
        part = fall.board.ball.radius / gap
        x = view.px(hit["x"] + part * (peg.x - hit["x"]))
        y = view.py(hit["y"] + part * (peg.y - hit["y"]))
        around = picture[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2]
        assert distance(around, THEMES["light"]["flash"]).min() < 25


def test_themes_differ(fall: Drop) -> None:
    light, dark = (decode(drop_png(fall, 300, theme)) for theme in ("light", "dark"))
    assert light.mean() > dark.mean() + 20


@pytest.mark.parametrize("width", [0, 239, 2049, -1, 10**9])
def test_a_width_out_of_range_is_refused(fall: Drop, width: int) -> None:
    with pytest.raises(InvalidValueError, match=str(width)):
        drop_png(fall, width)


def test_an_unknown_theme_is_refused(fall: Drop) -> None:
    with pytest.raises(InvalidValueError, match="'pink'"):
        drop_png(fall, 300, "pink")


# edges are smooth


def test_a_disc_covers_its_area_wherever_it_lies() -> None:
    for x, y, radius in ((20.0, 20.0, 5.0), (20.3, 19.8, 5.5), (20.5, 20.5, 12.25)):
        canvas = Canvas.blank(40, 40, (0, 0, 0))
        canvas.disc(x, y, radius, (255, 255, 255))
        assert canvas.pixels[..., 0].sum() / 255 == pytest.approx(math.pi * radius**2, rel=0.01)
        assert np.count_nonzero((canvas.pixels > 10) & (canvas.pixels < 245)) > 20


def test_a_box_covers_its_area() -> None:
    canvas = Canvas.blank(40, 40, (0, 0, 0))
    canvas.box((5.25, 6.5, 30.75, 20.5), 0.0, (255, 255, 255))
    assert canvas.pixels[..., 0].sum() / 255 == pytest.approx(25.5 * 14.0, rel=0.01)


def test_shapes_outside_of_the_picture_are_left_out() -> None:
    canvas = Canvas.blank(40, 40, (0, 0, 0))
    canvas.disc(1e12, -1e12, 3.0, (255, 255, 255))
    canvas.line((-1e9, -10.0, -1e8, -10.0), 3.0, (255, 255, 255))
    canvas.text(500.0, 500.0, "far", 12.0, (255, 255, 255))
    assert canvas.pixels.max() == 0.0
    canvas.disc(0.0, 0.0, 3.0, (255, 255, 255))
    assert canvas.pixels[..., 0].sum() / 255 == pytest.approx(math.pi * 9 / 4, rel=0.1)


# animations


@pytest.mark.parametrize("fmt", ["gif", "webp"])
def test_an_animation_runs_at_real_speed(fall: Drop, fmt: str) -> None:
    stays = [stay for _, stay in frames(drop_animation(fall, fmt, width=240, fps=30))]
    assert sum(stays[:-1]) == pytest.approx(fall.duration, abs=1 / 30 + 0.011)
    assert stays[-1] == HOLD


@pytest.mark.parametrize(("fmt", "tolerance"), [("gif", 0), ("webp", 40)])
def test_a_frame_shows_the_ball_where_it_is_and_leaves_the_rest(
    fall: Drop, fmt: str, tolerance: int
) -> None:
    view = lay_out(fall.board, 400)
    shown = [pixels for pixels, _ in frames(drop_animation(fall, fmt, width=400, fps=20))]
    for number in range(0, len(shown) - 1, 10):
        x, y = points_at(fall, view, np.array([number / 20]))[0]
        radius = fall.board.ball.radius * view.scale
        disc = shown[number][int(y - radius) : int(y + radius), int(x - radius) :]
        red = distance(disc[:, : int(2 * radius)], THEMES["light"]["ball"]) < 90
        assert red.mean() > 0.2
        # Below the ball and its trail nothing differs from the first frame.
        behind = np.maximum(number / 20 - TRAIL_STEP * np.arange(TRAIL + 1), 0.0)
        lowest = points_at(fall, view, behind)[:, 1].max()
        below = int(max(lowest, view.start) + radius + 3)
        assert abs(shown[number][below:] - shown[0][below:]).max(initial=0) <= tolerance


def test_the_last_frame_is_the_still_picture(fall: Drop) -> None:
    last = [pixels for pixels, _ in frames(drop_animation(fall, "webp", width=400, fps=5))][-1]
    assert abs(last - decode(drop_png(fall, 400))).mean() < 4


def test_a_gif_is_small_and_has_one_palette(fall: Drop) -> None:
    gif = drop_animation(fall, "gif")
    assert len(gif) < 1_000_000
    with Image.open(io.BytesIO(gif)) as image:
        palettes = set()
        for number in range(getattr(image, "n_frames", 1)):
            image.seek(number)
            colours = image.convert("RGB").getcolors(4096)
            assert colours is not None
            palettes |= {colour for _, colour in colours}
    assert len(palettes) <= 256


@pytest.mark.parametrize(
    ("arguments", "named"),
    [(("bmp",), "'bmp'"), (("gif", 760, 0), "fps 0"), (("gif", 760, 61), "fps 61")],
)
def test_an_animation_that_cannot_be_is_refused(
    fall: Drop, arguments: tuple[Any, ...], named: str
) -> None:
    with pytest.raises(InvalidValueError, match=named):
        drop_animation(fall, *arguments)


# any board


def odd_board(**changes: Any) -> Board:
    """A shaft from the start straight down to the bins, changed."""
    base: dict[str, Any] = {
        "walls": [
            {"x1": -1.0, "y1": -1.0, "x2": -1.0, "y2": 4.0},
            {"x1": 1.0, "y1": -1.0, "x2": 1.0, "y2": 4.0},
        ],
        "bins": {"y": 3.0, "edges": [-1.0, 0.0, 1.0], "multipliers": [1.0, 2.0]},
        "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
    }
    return Board.from_json(base | changes)


ODD: dict[str, dict[str, Any]] = {
    "a very deep one": {
        "walls": [
            {"x1": -1.0, "y1": -1.0, "x2": -1.0, "y2": 5e3},
            {"x1": 1.0, "y1": -1.0, "x2": 1.0, "y2": 5e3},
        ],
        "bins": {"y": 900.0, "edges": [-1.0, 1.0], "multipliers": [1.0]},
    },
    "a very wide one": {
        "walls": [],
        "bins": {"y": 3.0, "edges": [-500.0, 500.0], "multipliers": [1.0]},
    },
    "one with many bins": {
        "bins": {
            "y": 3.0,
            "edges": [x / 500 for x in range(-500, 501)],
            "multipliers": [1e9] * 1000,
        },
    },
    "one with long words": {"name": "w" * 100},
    "one on which a ball never lands": {
        "walls": [
            {"x1": -1.0, "y1": -1.0, "x2": -1.0, "y2": 4.0},
            {"x1": 1.0, "y1": -1.0, "x2": 1.0, "y2": 4.0},
        ],
        "pegs": [{"x": 0.0, "y": 2.0, "radius": 0.3}],
        "drop": {"x": 0.0, "y": 0.0, "jitter": 0.0},
    },
}


@pytest.mark.parametrize("name", ODD)
def test_every_board_can_be_drawn(name: str) -> None:
    d = drop(odd_board(**ODD[name]), 1)
    for width in (240, 500):
        pixels = decode(drop_png(d, width))
        assert pixels.shape[1] == width
        assert pixels.shape[0] <= (MAX_ASPECT + 1.0) * width
        assert distance(pixels, THEMES["light"]["ball"]).min() < 60
    assert (d.unsettled is not None) == ("never" in name)


@pytest.mark.parametrize("preset", ["triangle-16", "classic", "galton"])
@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_presets_are_drawn_with_either_solver(preset: str, solver: str) -> None:
    board = Board.preset(preset)
    d = drop(board, 5, solver=solver)
    assert d.bin is not None
    view = lay_out(board, 500)
    changed = (decode(drop_png(d, 500)) != empty_board(d, view)).any(axis=-1)
    points = np.rint(points_at(d, view, np.linspace(0, d.duration, 300)) - 0.5).astype(int)
    assert changed[points[:, 1], points[:, 0]].mean() > 0.98


def test_a_palette_that_is_no_colour_is_refused() -> None:
    with pytest.raises(ValueError, match="'#12345'"):
        parse("#12345")


def test_the_page_and_the_pictures_read_the_same_file() -> None:
    path = static_directory() / "theme.json"
    assert path == Path(__file__).parents[2] / "static" / "theme.json"
