"""Pictures of drops show the ball's path in the page's colours, on any board."""

import io
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from plinko.app.errors import InvalidValueError
from plinko.app.render import drop_animation, drop_picture
from plinko.app.render.animation import HOLD, LONGEST, Animation, Film
from plinko.app.render.parts.balls import (
    TRAIL_POINTS,
    TRAIL_STEP,
    paint_balls,
    paint_trail,
    style_of,
)
from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.path import points_at, sample_times
from plinko.app.render.parts.view import MAX_ASPECT, View, lay_out
from plinko.app.render.raster import mp4
from plinko.app.render.raster.canvas import Canvas
from plinko.app.render.raster.encode import Still
from plinko.app.render.raster.palette import Palette
from plinko.app.render.raster.png import png
from plinko.app.render.still import drop_pixels
from plinko.app.render.theme import THEMES, Scheme, parse
from plinko.app.settings import static_directory
from plinko.engine import Board, Drop, Peg, Wall, drop
from plinko.engine.errors import MissingPartError
from plinko.engine.parameters import SolverName

Pixels = npt.NDArray[np.int64]


def decode(picture: bytes) -> Pixels:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB")).astype(np.int64)


def frames(animation: bytes) -> Iterator[tuple[Pixels, float]]:
    """Each frame and its duration in s."""
    with Image.open(io.BytesIO(animation)) as image:
        for number in range(getattr(image, "n_frames", 1)):
            image.seek(number)
            yield np.asarray(image.convert("RGB")).astype(np.int64), image.info["duration"] / 1000


def distance(pixels: Pixels, colour: tuple[int, int, int]) -> npt.NDArray[np.float64]:
    """The distance of each pixel's colour from a colour: 0 to 441."""
    apart: npt.NDArray[np.float64] = np.sqrt(((pixels - np.array(colour)) ** 2).sum(axis=-1))
    return apart


def painted_over(pixels: Pixels, board: Pixels) -> npt.NDArray[np.bool_]:
    """The pixels where a picture differs from the empty board by more than its palette does."""
    far: npt.NDArray[np.bool_] = np.sqrt(((pixels - board) ** 2).sum(axis=-1)) > 50.0
    return far


@pytest.fixture(scope="module")
def fall() -> Drop:
    return drop(Board.preset("triangle-8"), 42)


@pytest.fixture(scope="module")
def view(fall: Drop) -> View:
    return lay_out(fall.board, 760)


@pytest.fixture(scope="module")
def picture(fall: Drop) -> Pixels:
    return decode(drop_picture(fall))


def empty_board(d: Drop, view: View) -> Pixels:
    return board_pixels(d.board, view, "light").astype(np.int64)


# the still picture


def test_the_same_drop_is_the_same_picture_and_another_theme_another(fall: Drop) -> None:
    again = drop(Board.preset("triangle-8"), 42)
    plain = drop_picture(fall, width=300)
    assert plain == drop_picture(again, width=300)
    assert plain != drop_picture(drop(fall.board, 43), width=300)
    dark = drop_picture(fall, width=300, theme="dark")
    assert decode(plain).mean() > decode(dark).mean() + 20


def test_the_whole_path_is_drawn_and_nothing_far_from_it(
    fall: Drop, view: View, picture: Pixels
) -> None:
    assert picture.shape == (view.height, 760, 3)
    for x, y in ((fall.board.bins.edges[0], fall.board.bins.y), (0.0, fall.board.drop.y)):
        assert 0 <= view.px(x) < 760
        assert 0 <= view.py(y) < view.height
    changed = painted_over(picture, empty_board(fall, view))
    points = points_at(fall, view, np.linspace(0.0, fall.duration, 500))
    inside = np.rint(points - 0.5).astype(int)
    assert changed[inside[:, 1], inside[:, 0]].mean() > 0.99
    rows, columns = np.nonzero(changed[: int(view.bin_top - 4)])  # the lit bin has a rim
    below = rows > view.start - 20  # the caption is above
    spots = np.column_stack([columns[below], rows[below]]) + 0.5
    nearest = np.sqrt(((spots[::7, None, :] - points[None]) ** 2).sum(axis=-1)).min(axis=1)
    assert nearest.max() < 1.6 * fall.board.ball.radius * view.scale + 8.0  # with its shadow


def test_the_path_is_sampled_at_every_impact_and_finely(fall: Drop, view: View) -> None:
    times = sample_times(fall, view, fall.duration)
    assert set(fall.impacts["t"]) <= set(times)
    points = points_at(fall, view, times)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 2.0


def test_the_ball_is_at_its_start_and_in_its_bin(fall: Drop, view: View, picture: Pixels) -> None:
    """A little to the right of the band through its middle the ball is red."""
    ball = THEMES["light"]["ball"]
    radius = fall.board.ball.radius * view.scale
    for x, y in ((fall.x_start, fall.board.drop.y), (fall.x_end, fall.board.bins.y)):
        column, row = view.px(x), view.py(y)
        around = picture[int(row - radius) : int(row + radius), int(column - radius) :][
            :, : int(2 * radius)
        ]
        assert (distance(around, ball) < 60).mean() > 0.2


def test_bins_have_the_page_s_colours_and_the_hit_one_a_rim(
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
    """Checks only the last mark at each place: small bounces on one peg cover each other."""
    hits = fall.impacts[fall.impacts["kind"] == 0]
    pegs = hits["index"].tolist()
    last = [hits[i] for i in range(len(hits)) if pegs[i] not in pegs[i + 1 :]]
    assert len(last) > 3
    for hit in last:
        peg = fall.board.pegs[hit["index"]]
        gap = math.hypot(peg.x - hit["x"], peg.y - hit["y"])
        part = fall.board.ball.radius / gap
        x = view.px(hit["x"] + part * (peg.x - hit["x"]))
        y = view.py(hit["y"] + part * (peg.y - hit["y"]))
        around = picture[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2]
        assert distance(around, THEMES["light"]["flash"]).min() < 25


@pytest.mark.parametrize(
    ("draw", "options", "named"),
    [
        *((drop_picture, {"width": width}, str(width)) for width in (0, 239, 2049, -1, 10**9)),
        *((drop_picture, {"at": at}, str(at)) for at in (-0.001, math.nan, math.inf)),
        (drop_picture, {"theme": "pink"}, "'pink'"),
        (drop_picture, {"fmt": "bmp"}, "'bmp'"),
        (drop_animation, {"fmt": "bmp"}, "'bmp'"),
        (drop_animation, {"fmt": "gif", "fps": 0}, "fps 0"),
        (drop_animation, {"fmt": "gif", "fps": 61}, "fps 61"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    fall: Drop, draw: Callable[..., bytes], options: dict[str, Any], named: str
) -> None:
    with pytest.raises(InvalidValueError, match=named):
        draw(fall, **options)


def test_a_drop_on_the_moon_looks_like_it(fall: Drop) -> None:
    board = {**fall.board.to_dict(), "name": "triangle-8 · Moon · Clay (putty)"}
    there = drop(Board.from_json(board), seed=1)
    pixels = decode(drop_picture(there, width=300, theme="dark"))
    here, moon = (np.array(THEMES[name]["shoulder"]) for name in ("dark", "dark · moon"))
    assert (pixels == moon).all(axis=-1).sum() > 1000 > (pixels == here).all(axis=-1).sum()
    film = Film(there, 300, 10, "dark").first()
    assert (film == moon).all(axis=-1).sum() > 1000


# a moment, and other formats


def red_spots(pixels: Pixels, d: Drop, view: View, at: float) -> float:
    """The red part of the square around the ball's place at a time."""
    x, y = points_at(d, view, np.array([at]))[0]
    radius = d.board.ball.radius * view.scale
    square = pixels[int(y - radius) : int(y + radius), int(x - radius) : int(x + radius)]
    return float((distance(square, THEMES["light"]["ball"]) < 90).mean())


@pytest.mark.parametrize("part", [0.2, 0.6, 0.9])
def test_a_moment_shows_the_path_until_then_and_nothing_later(
    fall: Drop, view: View, part: float
) -> None:
    at = part * fall.duration
    pixels = decode(drop_picture(fall, at=at))
    assert red_spots(pixels, fall, view, at) > 0.2
    changed = painted_over(pixels, empty_board(fall, view))
    past = np.rint(points_at(fall, view, np.linspace(0.0, at, 300)) - 0.5).astype(int)
    assert changed[past[:, 1], past[:, 0]].mean() > 0.95
    reach = 2.0 * fall.board.ball.radius * view.scale
    here = points_at(fall, view, np.linspace(0.0, at, 300))
    to_come = points_at(fall, view, np.linspace(at, fall.duration, 300))
    far = np.sqrt(((to_come[:, None] - here[None]) ** 2).sum(axis=-1)).min(axis=1) > reach
    spots = np.rint(to_come[far] - 0.5).astype(int)
    assert not (distance(pixels, THEMES["light"]["ball"]) < 60)[spots[:, 1], spots[:, 0]].any()


def test_after_the_landing_every_moment_is_the_whole_drop(fall: Drop) -> None:
    whole = drop_picture(fall, width=300)
    assert drop_picture(fall, width=300, at=fall.duration) == whole
    assert drop_picture(fall, width=300, at=1e9) == whole
    assert drop_picture(fall, width=300, at=0.0) != whole


@pytest.mark.parametrize(("fmt", "name", "apart"), [("jpg", "JPEG", 3.0), ("webp", "WEBP", 4.0)])
def test_other_formats_show_the_same(fall: Drop, fmt: Still, name: str, apart: float) -> None:
    encoded = drop_picture(fall, fmt)
    with Image.open(io.BytesIO(encoded)) as image:
        assert image.format == name
    assert abs(decode(encoded) - decode(drop_picture(fall))).mean() < apart


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_palette_leaves_smooth_plates_without_bands(
    fall: Drop, view: View, theme: Scheme
) -> None:
    """Averaged over small squares, the plate's brightness is off by less than one step."""
    exact = drop_pixels(fall, view, theme)
    shown = decode(drop_picture(fall, theme=theme))
    plate = slice(round(view.start), round(view.bin_top))
    seen, meant = (
        np.asarray(Image.fromarray(pixels[plate].astype(np.uint8)).reduce(8)).astype(int)
        for pixels in (shown, exact)
    )
    assert np.quantile(abs(seen - meant), 0.98) <= 1
    assert abs(shown - exact).mean() < 0.5


def test_frequent_colours_are_kept_exactly_and_others_nearly() -> None:
    ramp = np.repeat(np.arange(90, dtype=np.uint8), 100)
    picture = np.stack([ramp, ramp // 2, 255 - ramp], axis=-1).reshape(90, 100, 3)
    noisy = picture.copy()
    noisy[::7, ::9] = np.random.default_rng(5).integers(0, 255, noisy[::7, ::9].shape)
    palette = Palette([noisy])
    assert len(palette.colours) <= 255
    shown = palette.colours[palette.index(noisy)]
    smooth = (noisy == picture).all(axis=-1)
    assert (shown[smooth] == noisy[smooth]).all()
    assert distance(shown[~smooth].astype(int) - noisy[~smooth], (0, 0, 0)).mean() < 30


def test_an_index_is_that_of_the_nearest_colour() -> None:
    chance = np.random.default_rng(3)
    palette = Palette([chance.integers(0, 256, (40, 40, 3), np.uint8)])
    pixels = chance.integers(0, 256, (50, 60, 3), np.uint8)
    apart = ((pixels[..., None, :].astype(int) - palette.colours) ** 2).sum(axis=-1)
    found = np.take_along_axis(apart, palette.index(pixels)[..., None].astype(int), axis=-1)
    assert (found[..., 0] == apart.min(axis=-1)).all()
    # A PNG of such indices is read back as it was.
    colours = chance.integers(0, 256, (17, 3), np.uint8)
    index = chance.integers(0, 17, (9, 13), np.uint8)
    assert (decode(png(index, colours)) == colours[index]).all()


# balls


def test_a_ball_covers_its_area_wherever_it_lies() -> None:
    """The shadow has the plate's colour here, so only the ball is visible."""
    style = style_of(6.3, "light")
    for x, y in ((20.0, 20.0), (20.37, 19.81), (20.5, 20.25)):
        plate = np.empty((40, 40, 3), np.uint8)
        plate[:] = style.paint.shadow.astype(np.uint8)
        paint_balls(plate, np.array([x]), np.array([y]), np.zeros(1), style, 40)
        rows, columns = np.nonzero((plate != style.paint.shadow.astype(np.uint8)).any(axis=-1))
        assert len(rows) == pytest.approx(math.pi * 6.8**2, rel=0.06)
        assert rows.mean() + 0.5 == pytest.approx(y, abs=0.15)
        assert columns.mean() + 0.5 == pytest.approx(x, abs=0.15)


def test_a_balls_band_turns_with_it_clockwise() -> None:
    """Positive angles turn +x towards +y, which points down."""
    style = style_of(12.0, "light")
    for theta, along, across in ((0.0, (8, 0), (0, 8)), (math.pi / 4, (6, 6), (6, -6))):
        plate = np.zeros((40, 40, 3), np.uint8)
        paint_balls(plate, np.array([20.0]), np.array([20.0]), np.array([theta]), style, 40)
        light, dark = (plate[20 + dy, 20 + dx].astype(int) for dx, dy in (along, across))
        assert distance(light, THEMES["light"]["ballBand"]) < distance(
            dark, THEMES["light"]["ballBand"]
        )


def test_a_ball_sinks_behind_the_bins_and_far_balls_are_left_out() -> None:
    style = style_of(6.0, "light")
    plate = np.zeros((40, 40, 3), np.uint8)
    places = np.array([20.0, 1e12, math.nan, -500.0])
    paint_balls(plate, places, np.array([20.0, 5.0, 5.0, 5.0]), np.zeros(4), style, 20)
    assert plate[19, 20].any()
    assert not plate[20:].any()
    assert not plate[:12].any()
    # A trail narrows towards where the ball came from.
    plate = np.zeros((60, 60, 3), np.uint8)
    points = np.column_stack([np.linspace(50.0, 10.0, 9), np.full(9, 30.0)])
    paint_trail(plate, points, style, 60)
    widths = (plate.any(axis=-1)).sum(axis=0)
    assert widths[48] > widths[30] > widths[14] > 0
    assert widths[5] == 0


# edges are smooth


def test_a_disc_covers_its_area_wherever_it_lies_and_so_does_a_box() -> None:
    for x, y, radius in ((20.0, 20.0, 5.0), (20.3, 19.8, 5.5), (20.5, 20.5, 12.25)):
        canvas = Canvas.blank(40, 40, (0, 0, 0))
        canvas.disc(x, y, radius, (255, 255, 255))
        assert canvas.pixels[..., 0].sum() / 255 == pytest.approx(math.pi * radius**2, rel=0.01)
        assert np.count_nonzero((canvas.pixels > 10) & (canvas.pixels < 245)) > 20
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


@pytest.mark.parametrize("fps", [49, 50, 51, 59, 60])
def test_no_frame_of_a_gif_is_so_short_that_browsers_stretch_it(fps: int) -> None:
    """They show a delay of one hundredth of a second as ten."""
    short = drop(odd_board(bins={"y": 0.5, "edges": [-1.0, 1.0], "multipliers": [1.0]}), 1)
    stays = [stay for _, stay in frames(drop_animation(short, "gif", width=240, fps=fps))]
    assert min(stays) >= 0.02
    assert sum(stays[:-1]) == pytest.approx(short.duration, abs=0.021)
    assert len(stays) == math.ceil(short.duration * min(fps, 50)) + 1


@pytest.mark.parametrize(
    ("fmt", "tolerance", "apart"), [("gif", 0, 0.5), ("apng", 0, 0.5), ("webp", 20, 4.0)]
)
def test_an_animation_shows_the_ball_where_it_is_in_real_time_and_then_the_still(
    fall: Drop, fmt: Animation, tolerance: int, apart: float
) -> None:
    view = lay_out(fall.board, 300)
    film = drop_animation(fall, fmt, width=300, fps=20)
    shown, stays = zip(*frames(film), strict=True)
    assert len(stays) == math.ceil(fall.duration * 20) + 1
    assert sum(stays[:-1]) == pytest.approx(fall.duration, abs=1 / 20 + 0.011)
    assert stays[-1] == HOLD
    assert abs(shown[-1] - decode(drop_picture(fall, width=300))).mean() < apart
    bare = np.median(np.stack(shown[:-1:4]), axis=0).astype(np.int64)  # the empty board
    for number in range(0, len(shown) - 1, 10):
        assert red_spots(shown[number], fall, view, number / 20) > 0.2
        # Outside the ball, its shadow and its trail the board is empty.
        behind = np.maximum(number / 20 - TRAIL_STEP * np.arange(TRAIL_POINTS), 0.0)
        points = points_at(fall, view, behind)
        reach = 1.6 * fall.board.ball.radius * view.scale + 3
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        left, top = np.maximum(low, 0.0).astype(int)
        right, bottom = high.astype(int) + 1
        off = abs(shown[number] - bare)
        off[top:bottom, left:right] = 0
        assert np.quantile(off, 1.0 if tolerance == 0 else 0.999) <= tolerance


def test_a_gif_is_small_and_has_one_palette(fall: Drop) -> None:
    """Less than 250 kB a second, at 30 frames a second."""
    gif = drop_animation(fall, "gif")
    assert len(gif) < 250_000 * fall.duration
    with Image.open(io.BytesIO(gif)) as image:
        colours = set()
        for number in range(getattr(image, "n_frames", 1)):
            image.seek(number)
            found = image.convert("RGB").getcolors(4096)
            assert found is not None
            colours |= {colour for _, colour in found}
    assert len(colours) <= 256


def test_a_short_fall_and_a_long_one_are_shown(fall: Drop) -> None:
    """The film of a long fall stops after LONGEST seconds, and then shows the result."""
    assert (
        len(list(frames(drop_animation(fall, "gif", 240, fps=1)))) == math.ceil(fall.duration) + 1
    )
    walls = [{"x1": side, "y1": -1.0, "x2": side, "y2": 600.0} for side in (-1.0, 1.0)]
    bins = {"y": 500.0, "edges": [-1.0, 1.0], "multipliers": [1.0]}
    slow = drop(odd_board(walls=walls, bins=bins, gravity=0.2), 1)
    assert slow.duration > 1.1 * LONGEST
    assert len(list(frames(drop_animation(slow, "gif", 240, fps=1)))) == LONGEST + 1


def video(film: bytes) -> tuple[Any, list[Pixels]]:
    """The video stream of an MP4 film, and its frames."""
    with av.open(io.BytesIO(film), "r") as container:
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
        stream = container.streams.video[0]
        return stream, [picture.astype(np.int64) for picture in pictures]


def test_an_mp4_shows_the_same_in_real_time_for_all_browsers(
    fall: Drop,
) -> None:
    film = drop_animation(fall, "mp4", width=401, fps=10)
    stream, shown = video(film)
    view = lay_out(fall.board, 401)
    assert shown[0].shape == (view.height + view.height % 2, 402, 3), "its sides are even"
    assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
    assert film.index(b"moov") < film.index(b"mdat"), "a browser would wait for the end of the file"
    falling = math.ceil(fall.duration * 10)
    assert len(shown) == falling + 10 * HOLD
    assert float(stream.duration * stream.time_base) == len(shown) / 10
    same = [pixels for pixels, _ in frames(drop_animation(fall, "apng", width=401, fps=10))]
    for number in (0, falling // 2, falling):
        height, width = same[number].shape[:2]
        assert abs(shown[number][:height, :width] - same[number]).mean() < 4.0  # as WebP
    assert abs(shown[-1] - shown[falling]).mean() < 1.0
    assert drop_animation(fall, "mp4", width=401, fps=10) == film


def test_without_its_library_a_film_as_mp4_says_what_to_install(
    fall: Drop, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mp4, "find_spec", lambda name: None)
    with pytest.raises(MissingPartError, match=r"plinko-sim\[video\]"):
        drop_animation(fall, "mp4")


# any board


def odd_board(**changes: Any) -> Board:
    """A shaft from the start straight down to the bins, changed."""
    base: dict[str, Any] = {
        "walls": [{"x1": side, "y1": -1.0, "x2": side, "y2": 4.0} for side in (-1.0, 1.0)],
        "bins": {"y": 3.0, "edges": [-1.0, 0.0, 1.0], "multipliers": [1.0, 2.0]},
        "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
    }
    return Board.from_json(base | changes)


ODD: dict[str, dict[str, Any]] = {
    "a very deep one": {
        "walls": [{"x1": side, "y1": -1.0, "x2": side, "y2": 5e3} for side in (-1.0, 1.0)],
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
        "pegs": [{"x": 0.0, "y": 2.0, "radius": 0.3}],
        "drop": {"x": 0.0, "y": 0.0, "jitter": 0.0},
    },
}


@pytest.mark.parametrize("name", ODD)
def test_every_board_can_be_drawn(name: str) -> None:
    d = drop(odd_board(**ODD[name]), 1)
    for width in (240, 500):
        pixels = decode(drop_picture(d, width=width))
        assert pixels.shape[1] == width
        assert pixels.shape[0] <= (MAX_ASPECT + 1.0) * width
        assert distance(pixels, THEMES["light"]["ball"]).min() < 60
    assert (d.unsettled is not None) == ("never" in name)


def enlarged(by: float) -> Board:
    """The preset `triangle-8` in another size."""
    board = Board.preset("triangle-8")
    zone = board.drop
    return board.replace(
        name="enlarged",
        ball={"radius": by * board.ball.radius},
        pegs=[Peg(by * peg.x, by * peg.y, by * peg.radius) for peg in board.pegs],
        walls=[Wall(by * w.x1, by * w.y1, by * w.x2, by * w.y2) for w in board.walls],
        bins={"y": by * board.bins.y, "edges": [by * x for x in board.bins.edges]},
        drop={"jitter": by * zone.jitter, "reach": by * zone.reach, "aim": by * zone.aim},
        gravity=min(by, 1.0) * board.gravity,
    )


@pytest.mark.parametrize("width", [0.01, 0.1, 5.0, 100.0, 1000.0])
def test_a_board_of_any_size_fills_its_picture_as_a_preset_does(width: float) -> None:
    """Margins, rails and bins differ no more than those of a board 6 m and of one 8 m wide."""
    preset = Board.preset("triangle-8")
    board = enlarged(width / (preset.bins.edges[-1] - preset.bins.edges[0]))
    views = lay_out(board, 760), lay_out(preset, 760)
    for ends in ((board.walls[2].x2, preset.walls[2].x2), (board.bins.y, preset.bins.y)):
        one, other = (view.px(at) for view, at in zip(views, ends, strict=True))
        assert one == pytest.approx(other, abs=8.0)
    assert views[0].bin_height == pytest.approx(views[1].bin_height, rel=0.2)
    rail = THEMES["light"]["rail"]
    shares = [
        (board_pixels(each, view, "light") == rail).all(axis=-1).mean()
        for each, view in zip((board, preset), views, strict=True)
    ]
    assert shares[0] == pytest.approx(shares[1], rel=0.3)


@pytest.mark.parametrize("preset", ["triangle-16", "classic", "galton"])
@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_presets_are_drawn_with_either_solver(preset: str, solver: SolverName) -> None:
    board = Board.preset(preset)
    d = drop(board, 5, solver=solver)
    assert d.bin is not None
    view = lay_out(board, 500)
    changed = painted_over(decode(drop_picture(d, width=500)), empty_board(d, view))
    points = np.rint(points_at(d, view, np.linspace(0, d.duration, 300)) - 0.5).astype(int)
    assert changed[points[:, 1], points[:, 0]].mean() > 0.98


def test_the_page_and_the_pictures_read_the_same_file() -> None:
    with pytest.raises(ValueError, match="'#12345'"):
        parse("#12345")
    path = static_directory() / "theme.json"
    assert path == Path(__file__).parents[3] / "static" / "theme.json"
    shapes = json.loads(path.read_text(encoding="utf-8"))["shapes"]
    assert THEMES["light"].shapes == THEMES["dark"].shapes == shapes
    style = style_of(10.0, "light")
    assert style.paint.half_band == shapes["ball"]["band"]
    assert style.paint.shadow_across == shapes["ball"]["shadow"]["across"]
    opacity = shapes["ball"]["gloss"][0]["alpha"]
    assert style.paint.gloss[..., 3].max() == pytest.approx(opacity, abs=0.05)
    for name in ("ball.js", "board.js"):  # the page reads the numbers from the theme
        script = (static_directory() / "js" / "paint" / name).read_text(encoding="utf-8")
        assert "0.24" not in script
        assert "0.45" not in script.replace("0.45 + 0.55", "")
