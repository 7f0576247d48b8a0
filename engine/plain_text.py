"""Checks short texts from strangers, such as names, before a page, picture or list shows them.

Refused are characters that are invisible, change the direction of the text around them, or cover
the lines above: control and format characters (including bidirectional ones), spaces except single
plain ones inside, and more than two marks on a letter. static/js/solver/input/plain-text.js has the
same rules.
"""

import re
import unicodedata
from typing import Final

_UNSEEN: Final = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\ufe00-\ufe0f\uffa0]")
"""Invisible characters whose category is letter or mark."""

_MARKS: Final = 2  # most marks on a letter; after NFC no orthography needs more


def normal(value: object) -> str:
    """`value` in Unicode's form NFC, or an empty text if it is not a string."""
    return unicodedata.normalize("NFC", value) if isinstance(value, str) else ""


def fault(text: str, most: int) -> str | None:
    """Return the first requirement that `text` violates, to continue 'it must be'; None if valid.

    text: from `normal`. most: largest number of characters.
    """
    if not 0 < len(text) <= most:
        return f"a text of 1 to {most} characters"
    if not text.isprintable() or _UNSEEN.search(text):
        return "plain text: letters, marks, figures, signs, spaces"
    if text != " ".join(text.split()):
        return "a text without spaces at its ends or two in a row"
    if _most_marks(text) > _MARKS or unicodedata.category(text[0]).startswith("M"):
        return f"a text with at most {_MARKS} marks on a letter"
    return None


def _most_marks(text: str) -> int:
    most = marks = 0
    for character in text:
        marks = marks + 1 if unicodedata.category(character).startswith("M") else 0
        most = max(most, marks)
    return most
