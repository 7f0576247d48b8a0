"""Decodes a request's body, with an error that names the field that is wrong."""

import re
from typing import TypeVar

import msgspec

from plinko.app.errors import InvalidValueError, MalformedError
from plinko.engine import json_text

T = TypeVar("T")


def decode(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`.

    Raises JsonSyntaxError, JsonValueError and the errors of `shaped`.
    """
    json_text.parse(body)  # stricter than msgspec: it refuses duplicate keys
    return shaped(body, kind)


def shaped(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`, for a caller that has it checked by `json_text.parse` elsewhere.

    Raises InvalidValueError for a wrong shape, MalformedError for text that is not JSON.
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
    """The field that a message of msgspec is about; `body` if it is the whole body."""
    place, name = _PLACE.search(message), _NAME.search(message)
    parts = [place["path"] if place else "", name["name"] if name else ""]
    return ".".join(filter(None, parts)) or "body"
