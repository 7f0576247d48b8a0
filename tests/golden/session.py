"""Makes session.json and draw_session.json anew: what checkers of sessions are tried on."""

import json
from pathlib import Path

from tests.app.fairness.sessions import draw, honest

FILE = Path(__file__).with_name("session.json")
DRAWN_FILE = Path(__file__).with_name("draw_session.json")


def text() -> str:
    """The session as it must be."""
    return json.dumps(honest(4), indent=1) + "\n"


def drawn_text() -> str:
    """The session of a room with a draw as it must be."""
    return json.dumps(honest(6, drawing=draw()), indent=1) + "\n"


if __name__ == "__main__":
    FILE.write_text(text())
    DRAWN_FILE.write_text(drawn_text())
