"""Makes tests/golden/session.json anew: what checkers of sessions are tried on."""

import json
from pathlib import Path

from tests.app.fairness.sessions import honest

FILE = Path(__file__).with_name("session.json")


def text() -> str:
    """The file as it must be."""
    return json.dumps(honest(4), indent=1) + "\n"


if __name__ == "__main__":
    FILE.write_text(text())
