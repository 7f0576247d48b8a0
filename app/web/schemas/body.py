"""A request's bytes as a body, or the error that says best what is wrong with them."""

import contextlib
import json
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
        raise InvalidValueError(f"body: {error}", field="body") from None
    except RecursionError:
        raise MalformedError("the body's JSON is nested too deeply", field="body") from None
    except (msgspec.DecodeError, ValueError) as error:
        _explain(body, error)


def _explain(body: bytes, error: Exception) -> NoReturn:
    """Raise the error that says best why `body` is not JSON."""

    def no_constant(name: str) -> NoReturn:
        raise InvalidValueError(f"body: {name} is not a JSON number", field="body")

    # What is not JSON in any dialect keeps the first reader's message.
    with contextlib.suppress(ValueError, RecursionError):
        json.loads(body, parse_constant=no_constant)
    raise MalformedError(f"the body is not JSON: {error}", field="body") from None
