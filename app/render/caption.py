"""The strip above the board: what was dropped, where from, and how it ended."""

from typing import Final

from app.render.canvas import Canvas, text_width
from app.render.view import HEADER, View
from app.theme import Theme
from engine import Drop

SMALLEST: Final = 9.0  # px, of letters one can read


def paint_caption(canvas: Canvas, d: Drop, view: View, theme: Theme, ended: bool = True) -> None:
    """Paint the strip; without the result while the ball still falls."""
    height, margin = HEADER * view.unit, 16.0 * view.unit
    canvas.box((0.0, 0.0, float(view.width), height), 0.0, theme["case"])
    edge = (0.0, height - 2.0 * view.unit, float(view.width), height)
    canvas.box(edge, 0.0, theme["caseEdge"])
    room = view.width - 2.0 * margin
    if ended:
        room -= _paint_result(canvas, d, view, theme) + margin
    title = _title(d)
    size = min(20.0 * view.unit, room / text_width(title, 100.0) * 100.0)
    canvas.text(margin, 0.36 * height, title, size, theme["ink"], "lm")
    facts = _facts(d) if ended else _facts(d)[:1]
    size = max(12.0 * view.unit, SMALLEST)
    while facts and text_width("     ".join(facts), size) > room:
        facts.pop()
    if facts:
        canvas.text(margin, 0.73 * height, "     ".join(facts), size, theme["inkSoft"], "lm")


def _title(d: Drop) -> str:
    return d.board.name if d.seed is None or d.explicit_x else f"{d.board.name}   seed {d.seed}"


def _facts(d: Drop) -> list[str]:
    """Most telling first: what does not fit is left out from the end."""
    return [
        f"start x = {d.x_start:.4f} m",
        f"{len(d.impacts)} impacts in {d.duration:.3f} s",
        f"digest {d.digest[:16]}",
    ]


def _paint_result(canvas: Canvas, d: Drop, view: View, theme: Theme) -> float:
    """The score on a plate at the right; its width in px."""
    words = "unsettled" if d.bin is None else f"{d.score:g}x"
    look = theme.payout(d.score)
    size = 24.0 * view.unit
    wide = text_width(words, size) + 24.0 * view.unit
    right, height = view.width - 16.0 * view.unit, HEADER * view.unit
    plate = (right - wide, 0.16 * height, right, 0.8 * height)
    canvas.box(plate, 8.0 * view.unit, look.fill)
    canvas.text(right - 0.5 * wide, 0.48 * height, words, size, look.ink)
    return wide
