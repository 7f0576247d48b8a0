"""Pictures of many drops: sheets, densities and histograms agree with the drops."""

import io
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from plinko.app.errors import InvalidValueError
from plinko.app.render import contact_sheet, density_picture, histogram_picture
from plinko.app.render.histogram import expected_of
from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.view import fit, lay_out
from plinko.app.render.sheet import GAP, LABEL, MOST_DROPS
from plinko.app.render.still import drop_pixels
from plinko.app.render.theme import THEMES
from plinko.engine import Board, drop
from plinko.engine.payouts.record import odds_of_record

Pixels = npt.NDArray[np.int64]

BOARD = Board.preset("triangle-8")
LIGHT = THEMES["light"]


def decode(picture: bytes) -> Pixels:
    with Image.open(io.BytesIO(picture)) as image:
        return np.asarray(image.convert("RGB")).astype(np.int64)


def near(pixels: Pixels, colour: tuple[int, int, int], far: float = 12.0) -> Any:
    return np.sqrt(((pixels - np.array(colour)) ** 2).sum(axis=-1)) < far


# sheets


def test_a_sheet_has_each_drop_in_its_place() -> None:
    seeds, columns, width = [5, 2, 9, 7, 1], 3, 640
    sheet = decode(contact_sheet(BOARD, seeds, width=width, columns=columns))
    view = fit(BOARD, (width - GAP) // columns - GAP, header=0.0)
    pitch_x, pitch_y = view.width + GAP, view.height + LABEL + GAP
    assert sheet.shape == (2 * pitch_y + GAP, width, 3)
    left = (width - columns * pitch_x + GAP) // 2
    for number, seed in enumerate(seeds):
        x, y = left + number % 3 * pitch_x, GAP + number // 3 * pitch_y + LABEL
        tile = sheet[y : y + view.height, x : x + view.width]
        apart = {
            other: abs(tile - drop_pixels(drop(BOARD, other), view, "light").astype(int)).mean()
            for other in seeds
        }
        assert min(apart, key=lambda other: apart[other]) == seed
        assert apart[seed] < 2.0
        paid = LIGHT.payout(drop(BOARD, seed).score).fill
        assert near(sheet[y - LABEL : y, x : x + view.width], paid).sum() > 100
    empty = sheet[pitch_y + GAP :, left + 2 * pitch_x :]
    assert near(empty, LIGHT["case"], 4.0).all()


def test_a_sheet_is_about_square_and_reports_its_progress() -> None:
    told: list[int] = []
    picture = decode(contact_sheet(BOARD, range(9), width=500, progress=told.append))
    assert told == list(range(1, 10))
    assert 0.7 < picture.shape[0] / picture.shape[1] < 1.4


@pytest.mark.parametrize(
    ("count", "options", "named"),
    [
        (0, {}, "not 0"),
        (MOST_DROPS + 1, {}, f"not {MOST_DROPS + 1}"),
        (4, {"columns": 0}, "columns 0"),
        (4, {"columns": 5}, "columns 5"),
        (9, {"width": 100}, "width 100"),
        (9, {"width": 300, "columns": 3}, "width 300"),
        (4, {"width": 4000}, "width 4000"),
        (100, {"columns": 1, "width": 2048}, "100 drops in 1 columns"),
        (4, {"fmt": "gif"}, "'gif'"),
        (4, {"theme": "pink"}, "'pink'"),
    ],
)
def test_a_sheet_that_cannot_be_is_refused(count: int, options: dict[str, Any], named: str) -> None:
    with pytest.raises(InvalidValueError, match=named):
        contact_sheet(BOARD, range(count), **options)


# density


def test_light_is_where_balls_were_and_brighter_where_they_were_longer() -> None:
    view = lay_out(BOARD, 400)
    picture = decode(density_picture(BOARD, range(2000), width=400))
    bare = board_pixels(BOARD, view, "light").astype(int)
    lit = np.sqrt(((picture - bare) ** 2).sum(axis=-1)) > 40
    field = slice(round(view.start) + 2, round(view.bin_top) - 2)
    ball = BOARD.ball.radius
    for peg in BOARD.pegs:  # no ball's centre comes within a radius of a peg's rim
        x, y = round(view.px(peg.x)), round(view.py(peg.y))
        reach = int((peg.radius + 0.6 * ball) * view.scale / 1.5)
        assert not lit[y - reach : y + reach, x - reach : x + reach].any()
    start = round(view.px(BOARD.drop.x))
    assert lit[round(view.start) + 4, start - 3 : start + 4].all()
    shoulder = lit[round(view.start) : round(0.6 * view.bin_top), : round(0.15 * view.width)]
    assert not shoulder[:, : shoulder.shape[1] // 2].any()
    assert lit[field].mean() > 0.2
    # All balls pass just below the start; few reach the outermost bins.
    light = picture.sum(axis=-1)
    begin = light[round(view.start) + 6, round(view.px(0.0))]
    row = round(view.bin_top) - 4
    edge = light[row, round(view.px(BOARD.bins.edges[0])) + 6 :][:20].mean()
    assert begin > edge + 150


def test_a_density_is_the_same_however_it_is_computed() -> None:
    pictures = {
        density_picture(BOARD, range(400), width=300, threads=threads) for threads in (1, 2)
    }
    assert len(pictures) == 1
    assert density_picture(BOARD, range(1, 401), width=300) not in pictures


def test_a_density_says_when_a_ball_never_lands() -> None:
    walls = [{"x1": x, "y1": -1.0, "x2": x, "y2": 4.0} for x in (-1.0, 1.0)]
    form = {"walls": walls, "pegs": [{"x": 0.0, "y": 2.0, "radius": 0.3}], "drop": {"jitter": 0.0}}
    bins = {"y": 3.0, "edges": [-1.0, 1.0], "multipliers": [1.0]}
    board = Board.from_json({**form, "bins": bins})
    assert decode(density_picture(board, [1, 2], width=300)).shape[1] == 300


# histograms


def columns_of(picture: Pixels, board: Board) -> list[int]:
    """The height of each column in pixels, found by the colour of its bin."""
    edges = np.linspace(16, picture.shape[1] - 16, board.bins.count + 1)
    floor = picture.shape[0] - 44
    heights = []
    for number, score in enumerate(board.bins.multipliers):
        x = round(edges[number] + 0.2 * (edges[1] - edges[0]))
        fill = near(picture[60:floor, x], LIGHT.payout(score).fill, 8.0)
        mark = near(picture[60:floor, x], LIGHT["tray"], 8.0)
        heights.append(
            int(fill.sum()) + int((~fill & ~mark)[fill.argmax() :].sum()) * bool(fill.any())
        )
    return heights


def test_columns_are_as_high_as_their_bins_are_full() -> None:
    counts = [0, 10, 20, 50, 100, 50, 20, 10, 0]
    board = Board.from_json(BOARD.to_dict() | {"name": "no law known"})
    heights = columns_of(decode(histogram_picture(board, counts)), board)
    assert heights[0] == heights[8] == 0
    for count, height in zip(counts, heights, strict=True):
        assert height == pytest.approx(heights[4] * count / 100, abs=2)
    assert heights[4] > 200
    wrong: list[Any] = [[1, 2], [1] * 8 + [-1], [[1] * 9]]
    for each in wrong:
        with pytest.raises(InvalidValueError, match="counts"):
            histogram_picture(BOARD, each)


def test_only_a_preset_is_compared_with_its_odds() -> None:
    found = expected_of(BOARD)
    assert found is not None
    assert found.tolist() == list(odds_of_record(BOARD)[0].chances)
    assert expected_of(Board.preset("galton")) is None
    assert expected_of(Board.from_json(BOARD.to_dict() | {"drag": 2.0})) is None
    counts = (found * 25_600).round().astype(int)
    marked = decode(histogram_picture(BOARD, counts))
    plain = decode(histogram_picture(Board.from_json(BOARD.to_dict() | {"name": "other"}), counts))
    mark = LIGHT["trayMark"]
    below = slice(100, None)
    assert near(marked[below], mark, 6.0).sum() > near(plain[below], mark, 6.0).sum() + 200


def test_a_mark_lies_on_top_of_a_column_that_is_as_expected() -> None:
    counts = (np.array(odds_of_record(BOARD)[0].chances) * 256_000).round().astype(int)
    picture = decode(histogram_picture(BOARD, counts))
    edges = np.linspace(16, picture.shape[1] - 16, 10)
    x = round(0.5 * (edges[4] + edges[5])) - 8
    fill = near(picture[:, x], LIGHT.payout(BOARD.bins.multipliers[4]).fill)
    mark = near(picture[:, x], LIGHT["trayMark"], 20.0)
    assert abs(np.argmax(fill) - np.argmax(mark[60:]) - 60) < 8
