"""Makes tests/golden/session.json anew: what checkers of sessions are tried on."""

from pathlib import Path

from tests.app.fairness.sessions import honest
from tests.golden.lines import in_lines

FILE = Path(__file__).with_name("session.json")


def text() -> str:
    """The file as it must be."""
    return in_lines(honest(4))


if __name__ == "__main__":
    FILE.write_text(text())
