"""Writes session.json and its neighbours, the samples for checkers of fair sessions."""

from pathlib import Path

from tests.app.fairness.sessions import draw, honest, restored
from tools.golden.lines import in_lines

FILE = Path(__file__).with_name("session.json")
DRAWN_FILE = Path(__file__).with_name("draw_session.json")
RESTORED_FILE = Path(__file__).with_name("restored_session.json")


def text() -> str:
    """The text of session.json."""
    return in_lines(honest(4))


def drawn_text() -> str:
    """The text of draw_session.json, the session of a room with a draw."""
    return in_lines(honest(6, drawing=draw()))


def restored_text() -> str:
    """The text of restored_session.json, of a void session before a change of the key."""
    return in_lines(restored())


if __name__ == "__main__":
    FILE.write_text(text())
    DRAWN_FILE.write_text(drawn_text())
    RESTORED_FILE.write_text(restored_text())
