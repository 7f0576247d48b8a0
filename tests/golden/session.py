"""Makes session.json and draw_session.json anew: what checkers of sessions are tried on."""

from pathlib import Path

from tests.app.fairness.sessions import draw, honest
from tests.golden.lines import in_lines

FILE = Path(__file__).with_name("session.json")
DRAWN_FILE = Path(__file__).with_name("draw_session.json")


def text() -> str:
    """The session as it must be."""
    return in_lines(honest(4))


def drawn_text() -> str:
    """The session of a room with a draw as it must be."""
    return in_lines(honest(6, drawing=draw()))


if __name__ == "__main__":
    FILE.write_text(text())
    DRAWN_FILE.write_text(drawn_text())
