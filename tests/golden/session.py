"""Writes session.json and draw_session.json, the samples for checkers of fair sessions."""

from pathlib import Path

from tests.app.fairness.sessions import draw, honest
from tests.golden.lines import in_lines

FILE = Path(__file__).with_name("session.json")
DRAWN_FILE = Path(__file__).with_name("draw_session.json")


def text() -> str:
    """The text of session.json."""
    return in_lines(honest(4))


def drawn_text() -> str:
    """The text of draw_session.json, the session of a room with a draw."""
    return in_lines(honest(6, drawing=draw()))


if __name__ == "__main__":
    FILE.write_text(text())
    DRAWN_FILE.write_text(drawn_text())
