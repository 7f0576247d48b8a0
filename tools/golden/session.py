"""Writes session.json and its neighbours, the samples for checkers of fair sessions."""

from pathlib import Path

from tools.fairness.sessions import draw, honest, restored
from tools.golden.lines import in_lines

GOLDEN = Path(__file__).parents[2] / "tests/golden"
FILE = GOLDEN / "session.json"
DRAWN_FILE = GOLDEN / "draw_session.json"
RESTORED_FILE = GOLDEN / "restored_session.json"


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
