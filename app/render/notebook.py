"""Draw the engine's values as PNG for notebooks: an entry point in pyproject.toml."""

from plinko.app.render.histogram import histogram_picture
from plinko.app.render.parts.board import board_pixels
from plinko.app.render.parts.view import lay_out
from plinko.app.render.raster import encode
from plinko.app.render.still import DEFAULT_WIDTH, drop_picture
from plinko.app.render.theme import at_place
from plinko.engine import Board, Drop, DropBatch


def png(value: Board | Drop | DropBatch) -> bytes:
    """Draw the board, the drop's path, or the batch's histogram, in the page's appearance."""
    if isinstance(value, Board):
        view, theme = lay_out(value, DEFAULT_WIDTH), at_place("light", value.name)
        return encode.still(board_pixels(value, view, theme), "png")
    if isinstance(value, Drop):
        return drop_picture(value)
    return histogram_picture(value.board, value.histogram, unsettled_count=value.unsettled_count)
