"""Names and colours of visitors and of drops, and their parsers. Pure.

No digest covers them. The ledger and the log keep the tag of a drop, but nothing of a visitor.
"""

import re
from typing import Final, TypedDict

import msgspec

from plinko.app.errors import InvalidValueError
from plinko.engine import plain_text
from plinko.engine.errors import shorten
from plinko.engine.json_text import Json

MAX_NAME: Final = 25  # characters, after NFC, as on Twitch

_COLOUR: Final = re.compile(r"#[0-9a-f]{6}")

_MARKUP: Final = re.compile("[<>&]")


class AppearMessage(msgspec.Struct, frozen=True, tag="appear", forbid_unknown_fields=True):
    """Become a visitor, with or without name and colour; repeat it to change them.

    Connections with the same `who` are one visitor. With `audience`, the client only receives the
    visitors.
    """

    name: Json = None
    colour: Json = None
    who: Json = None
    audience: bool = False


class Appearance(msgspec.Struct, frozen=True):
    """What a client has said in `appear`, parsed."""

    name: str | None = None
    colour: str | None = None
    who: str | None = None
    audience: bool = False


class Visitor(msgspec.Struct, frozen=True, omit_defaults=True):
    """A player that others see. `visitor` is the player's number, for this visit only."""

    visitor: int
    name: str | None = None
    colour: str | None = None


class TagForm(TypedDict, total=False):
    """The fields of a tag that are set."""

    name: str
    colour: str


class Tag(msgspec.Struct, frozen=True, omit_defaults=True):
    """A drop's name and colour, shown to spectators."""

    name: str | None = None
    colour: str | None = None

    @property
    def fields(self) -> TagForm:
        form: TagForm = {}
        if self.name is not None:
            form["name"] = self.name
        if self.colour is not None:
            form["colour"] = self.colour
        return form


TAG_FIELDS: Final = Tag.__struct_fields__

NO_TAG: Final = Tag()


def parse_tag(name: object, colour: object) -> Tag:
    """The tag of a drop; raises InvalidValueError for a bad name or colour."""
    return Tag(parse_name(name), parse_colour(colour))


def parse_name(value: object) -> str | None:
    """A name in Unicode's form NFC, or None; raises InvalidValueError for an invalid name.

    A name is invalid if `plinko.engine.plain_text` refuses it, or if it could be taken for markup.
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
    """A colour as #rrggbb, or None; raises InvalidValueError for any other spelling."""
    if value is None:
        return None
    if not isinstance(value, str) or not _COLOUR.fullmatch(value):
        raise InvalidValueError(
            f"colour {shorten(value)} is not # and six digits of 0-9 and a-f", field="colour"
        )
    return value
