"""A request's bytes as a body, or the error that says best what is wrong with them."""

import re
from typing import TypeVar

import msgspec

from app.errors import InvalidValueError, MalformedError
from engine import json_text

T = TypeVar("T")


def decode(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`.

    Raises JsonSyntaxError, JsonValueError and what `shaped` raises.
    """
    json_text.parse(body)
    return shaped(body, kind)


def shaped(body: bytes, kind: type[T]) -> T:
    """JSON that `json_text.parse` has read, or will read, as `kind`.

    Raises InvalidValueError for a wrong shape, MalformedError for what is not JSON.
    """
    try:
        return msgspec.json.decode(body, type=kind)
    except msgspec.ValidationError as error:
        raise InvalidValueError(f"body: {error}", field=_field(str(error))) from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedError(f"the body is not JSON: {error}", field="body") from None


_PLACE = re.compile(r" - at `(?:key in )?\$\.?(?P<path>[^`]*)`")
_NAME = re.compile(r"(?:unknown|required) field `(?P<name>[^`]*)`")


def _field(message: str) -> str:
    """Which field a decoder's message is about; `body` if it is the whole."""
    place, name = _PLACE.search(message), _NAME.search(message)
    parts = [place["path"] if place else "", name["name"] if name else ""]
    return ".".join(filter(None, parts)) or "body"
