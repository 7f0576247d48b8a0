"""Labels in pictures lie within their bins, in their colours; too long ones are cut."""

import pytest

from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.prizes import lettering, writable
from plinko.app.render.parts.view import lay_out
from plinko.app.render.still import drop_pixels
from plinko.engine import Board, Label, drop
from tests.long import tries

PLAIN = Board.preset("triangle-8")


def labelled(*texts: str, colour: str | None = None) -> Board:
    labels = [Label(text, colour) for text in texts]
    return PLAIN.replace(bins={"labels": [*labels, *[None] * (9 - len(texts))]})


def test_a_bin_has_its_label_s_colour_and_the_result_its_prize() -> None:
    board = PLAIN.replace(bins={"labels": [Label(f"mug {n}", "#0055ff") for n in range(9)]})
    picture = drop_pixels(drop(board, 3), lay_out(board, 480), "light")
    blue = (picture == (0, 0x55, 0xFF)).all(axis=-1)
    rows = blue.sum(axis=1)
    assert rows[: round(lay_out(board, 480).header)].max() > 20
    assert rows[-40:-20].min() > 200


def test_what_the_font_cannot_write_has_its_multiplier() -> None:
    assert writable("Caf\xe9 Gr\xf6\xdfe") == "Cafe Grosse"
    assert writable("\U0001f381 gift") is None
    board = labelled("\U0001f381 gift", "Mug")
    found = lettering(board, lay_out(board, 760))
    assert found[0].lines == (f"{PLAIN.bins.multipliers[0]:g}",)
    assert found[1].lines == ("Mug",)


@pytest.mark.long
@pytest.mark.parametrize(
    ("width", "rows"), tries([(240, 8), (240, 16), (760, 16)], [(240, 8), (760, 16), (2048, 8)])
)
def test_every_label_fits_into_its_bin(width: int, rows: int) -> None:
    plain = Board.preset(f"triangle-{rows}")
    texts = ["a", "A trip to Lisbon for two with breakfast", "W" * 40, "T-shirt"]
    labels = [Label(texts[n % 4]) for n in range(rows + 1)]
    board = plain.replace(bins={"labels": labels})
    view = lay_out(board, width)
    short = board.replace(bins={"labels": [Label("i")] * (rows + 1)})
    change = (board_pixels(board, view, "dark") != board_pixels(short, view, "dark")).any(axis=-1)
    edges = [round(view.px(x)) for x in board.bins.edges]
    assert change[: round(view.bin_top)].sum() == 0
    assert not change[:, edges].any(), "nothing is written over an edge"
