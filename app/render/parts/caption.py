"""Write the strip above the board: the drop's seed, start and result."""

from typing import Final

from plinko.app.render.parts.prizes import result_of
from plinko.app.render.parts.view import View
from plinko.app.render.raster.canvas import Canvas, text_width
from plinko.app.render.theme import Theme
from plinko.engine import Drop

SMALLEST: Final = 9.0  # px, of legible letters


def paint_caption(
    canvas: Canvas, d: Drop, view: View, theme: Theme, falling: float | None = None
) -> None:
    """Paint the strip. While the ball falls, `falling` is the time since the start in s."""
    room = paint_strip(canvas, view, theme)
    if falling is None:
        room -= _paint_result(canvas, d, view, theme) + 16.0 * view.unit
    paint_words(canvas, view, theme, _title(d), _facts(d, falling), room)


def paint_strip(canvas: Canvas, view: View, theme: Theme) -> float:
    """Paint the empty strip; returns the width in px for words."""
    canvas.box((0.0, 0.0, float(view.width), view.header), 0.0, theme["case"])
    edge = (0.0, view.header - 2.0 * view.unit, float(view.width), view.header)
    canvas.box(edge, 0.0, theme["caseEdge"])
    return view.width - 32.0 * view.unit


def paint_words(
    canvas: Canvas, view: View, theme: Theme, title: str, facts: list[str], room: float
) -> None:
    """Write a title, and below it as many of the facts as fit, the most important first."""
    height, margin = view.header, 16.0 * view.unit
    if title:
        size = min(20.0 * view.unit, room / text_width(title, 100.0) * 100.0)
        canvas.text(margin, 0.36 * height, title, size, theme["ink"], "lm")
    facts, size = [*facts], max(12.0 * view.unit, SMALLEST)
    while facts and text_width("     ".join(facts), size) > room:
        facts.pop()
    if facts:
        canvas.text(margin, 0.73 * height, "     ".join(facts), size, theme["inkSoft"], "lm")


def _title(d: Drop) -> str:
    return d.board.name if d.seed is None or d.explicit_x else f"{d.board.name}   seed {d.seed}"


def _facts(d: Drop, falling: float | None) -> list[str]:
    start = f"start x = {d.x_start:.4f} m"
    if falling is not None:
        done = int((d.impacts["t"] <= falling).sum())
        return [start, f"t = {falling:.3f} s", f"{done} impacts"] if falling else [start]
    return [
        start,
        f"{len(d.impacts)} impacts in {d.duration:.3f} s",
        f"digest {d.digest[:16]}",
    ]


def _paint_result(canvas: Canvas, d: Drop, view: View, theme: Theme) -> float:
    """Paint the score on a plate at the right; returns its width in px."""
    words, fill, ink = result_of(d, theme)
    size = min(24.0 * view.unit, 0.4 * view.width / text_width(words, 100.0) * 100.0)
    wide = text_width(words, size) + 24.0 * view.unit
    right, height = view.width - 16.0 * view.unit, view.header
    plate = (right - wide, 0.16 * height, right, 0.8 * height)
    canvas.box(plate, 8.0 * view.unit, fill)
    canvas.text(right - 0.5 * wide, 0.48 * height, words, size, ink)
    return wide
