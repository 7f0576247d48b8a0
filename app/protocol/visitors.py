"""What visitors say of themselves to the others at a table, and what of it is taken. Pure.

None of it is part of a room: no log, no digest, no result and no ledger ever has it.
"""

import re
import unicodedata
from typing import Any, Final

import msgspec

from app.errors import InvalidValueError, shorten

MAX_NAME: Final = 24  # characters, after NFC

_COLOUR: Final = re.compile(r"#[0-9a-f]{6}")

_MARKUP: Final = re.compile("[<>&]")
_UNSEEN: Final = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u2800\u3164\ufe00-\ufe0f\uffa0]")
"""Characters that are letters or marks by their category and show nothing."""

_MARKS: Final = 2  # one above the other; no orthography that NFC leaves apart needs more


class AppearMessage(msgspec.Struct, frozen=True, tag="appear", forbid_unknown_fields=True):
    """Be seen by others who are, under a name and in a colour, or under none; again to change."""

    name: Any = None
    colour: Any = None


class Visitor(msgspec.Struct, frozen=True, omit_defaults=True):
    """Somebody at a table. `visitor` is a number that the room gave, for this connection alone."""

    visitor: int
    name: str | None = None
    colour: str | None = None


def parse_name(value: object) -> str | None:
    """A visitor's name in Unicode's form NFC, or None; raises InvalidValueError saying why not.

    Refused is what could pass for markup, hide, turn the text around it, or cover what is above it:
    control and format characters (bidirectional ones among them), spaces but the plain one inside,
    and more than two marks on a letter.
    """
    if value is None:
        return None
    name = unicodedata.normalize("NFC", value) if isinstance(value, str) else ""
    if not 0 < len(name) <= MAX_NAME:
        raise _refused(value, f"a text of 1 to {MAX_NAME} characters")
    if not name.isprintable() or _MARKUP.search(name) or _UNSEEN.search(name):
        raise _refused(value, "plain text: letters, marks, figures, signs but <, > and &, spaces")
    if name != " ".join(name.split()):
        raise _refused(value, "a text without spaces at its ends or two in a row")
    if _most_marks(name) > _MARKS or unicodedata.combining(name[0]):
        raise _refused(value, f"a text with at most {_MARKS} marks on a letter")
    return name


def parse_colour(value: object) -> str | None:
    """A visitor's colour as #rrggbb, or None; raises InvalidValueError for any other spelling."""
    if value is None:
        return None
    if not isinstance(value, str) or not _COLOUR.fullmatch(value):
        raise InvalidValueError(
            f"colour {shorten(value)} is not # and six digits of 0-9 and a-f", field="colour"
        )
    return value


def _most_marks(text: str) -> int:
    most = marks = 0
    for character in text:
        marks = marks + 1 if unicodedata.category(character).startswith("M") else 0
        most = max(most, marks)
    return most


def _refused(value: object, right: str) -> InvalidValueError:
    return InvalidValueError(f"name {shorten(value)} is not {right}", field="name")
