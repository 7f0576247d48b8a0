"""Which short texts that strangers give may stand in a page, a picture or a list. Pure.

Refused is what could hide, turn the text around it, or cover what is above it: control and format
characters (bidirectional ones among them), spaces but the plain one inside, and more than two marks
on a letter. static/js/solver/input/plain-text.js has the same rules.
"""

import re
import unicodedata
from typing import Final

_UNSEEN: Final = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\ufe00-\ufe0f\uffa0]")
"""Characters that are letters or marks by their category and show nothing."""

_MARKS: Final = 2  # one above the other; no orthography that NFC leaves apart needs more


def normal(value: object) -> str:
    """`value` in Unicode's form NFC, or an empty text for what is not a text."""
    return unicodedata.normalize("NFC", value) if isinstance(value, str) else ""


def fault(text: str, most: int) -> str | None:
    """What a `normal` text of at most `most` characters would have to be, or None if it is that."""
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
