"""What visitors say of themselves to the others at a table, and what of it is taken. Pure.

None of it is part of a room: no log, no digest, no result and no ledger ever has it.
"""

import re
from typing import Any, Final

import msgspec

from app.errors import InvalidValueError, shorten
from engine import plain_text

MAX_NAME: Final = 24  # characters, after NFC

_COLOUR: Final = re.compile(r"#[0-9a-f]{6}")

_MARKUP: Final = re.compile("[<>&]")


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

    Refused is what `engine.plain_text` refuses, and what could pass for markup.
    """
    if value is None:
        return None
    name = plain_text.normal(value)
    right = plain_text.fault(name, MAX_NAME)
    if right is None and _MARKUP.search(name):
        right = "plain text without <, > and &"
    if right is not None:
        raise InvalidValueError(f"name {shorten(value)} is not {right}", field="name")
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
