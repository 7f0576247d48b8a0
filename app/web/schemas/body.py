"""A request's bytes as a body, or the error that says best what is wrong with them."""

import contextlib
import json
import re
from typing import NoReturn, TypeVar

import msgspec

from app.errors import InvalidValueError, MalformedError

T = TypeVar("T")


def decode(body: bytes, kind: type[T]) -> T:
    """A JSON body as `kind`.

    Raises MalformedError for what is not JSON, InvalidValueError for a wrong shape or for NaN and
    its kin, which JSON does not have.
    """
    try:
        return msgspec.json.decode(body, type=kind)
    except msgspec.ValidationError as error:
        raise InvalidValueError(f"body: {error}", field=_field(str(error))) from None
    except RecursionError:
        raise MalformedError("the body's JSON is nested too deeply", field="body") from None
    except (msgspec.DecodeError, ValueError) as error:
        _explain(body, error)


_PLACE = re.compile(r" - at `(?:key in )?\$\.?(?P<path>[^`]*)`")
_NAME = re.compile(r"(?:unknown|required) field `(?P<name>[^`]*)`")


def _field(message: str) -> str:
    """Which field a decoder's message is about; `body` if it is the whole."""
    place, name = _PLACE.search(message), _NAME.search(message)
    parts = [place["path"] if place else "", name["name"] if name else ""]
    return ".".join(filter(None, parts)) or "body"


def _explain(body: bytes, error: Exception) -> NoReturn:
    """Raise the error that says best why `body` is not JSON."""

    def no_constant(name: str) -> NoReturn:
        raise InvalidValueError(f"body: {name} is not a JSON number", field="body")

    # What is not JSON in any dialect keeps the first reader's message.
    with contextlib.suppress(ValueError, RecursionError):
        json.loads(body, parse_constant=no_constant)
    raise MalformedError(f"the body is not JSON: {error}", field="body") from None
