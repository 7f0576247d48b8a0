"""Names and colours: what visitors say of themselves, what a drop may carry, what is taken. Pure.

No digest covers any of it. What a visitor says is in no log, result or ledger either; the tag of a
drop is kept with the drop.
"""

import re
from typing import Final, TypedDict

import msgspec

from app.errors import InvalidValueError, shorten
from engine import plain_text
from engine.json_text import Json

MAX_NAME: Final = 24  # characters, after NFC

_COLOUR: Final = re.compile(r"#[0-9a-f]{6}")

_MARKUP: Final = re.compile("[<>&]")


class AppearMessage(msgspec.Struct, frozen=True, tag="appear", forbid_unknown_fields=True):
    """Be seen by others who are, under a name and in a colour, or under none; again to change."""

    name: Json = None
    colour: Json = None


class Visitor(msgspec.Struct, frozen=True, omit_defaults=True):
    """Somebody at a table. `visitor` is a number that the room gave, for this connection alone."""

    visitor: int
    name: str | None = None
    colour: str | None = None


class TagForm(TypedDict, total=False):
    """What is there of a tag."""

    name: str
    colour: str


class Tag(msgspec.Struct, frozen=True, omit_defaults=True):
    """What a drop carries for those who watch: whose it is, and the colour of its ball."""

    name: str | None = None
    colour: str | None = None

    @property
    def fields(self) -> TagForm:
        """What is there of it."""
        form: TagForm = {}
        if self.name is not None:
            form["name"] = self.name
        if self.colour is not None:
            form["colour"] = self.colour
        return form

    @property
    def marks(self) -> tuple[str, ...]:
        """What tells a request with this tag from the same one with another; nothing of none."""
        return () if self == NO_TAG else (self.name or "", self.colour or "")


TAG_FIELDS: Final = Tag.__struct_fields__

NO_TAG: Final = Tag()


def parse_tag(name: object, colour: object) -> Tag:
    """The tag of a drop; raises InvalidValueError for a bad name or colour."""
    return Tag(parse_name(name), parse_colour(colour))


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
