"""The messages that a client may send in any room, and their parser. Pure.

touching_messages.py has the messages for rooms of touching balls.
"""

import math
from typing import Final, get_args

import msgspec

from plinko.app.errors import InvalidValueError, MalformedError, UnknownMessageError
from plinko.app.protocol.messages import PROTOCOL_VERSION, SNAPSHOTS, STREAMS
from plinko.app.protocol.touching_messages import Change, ClaimMessage, WatchMessage
from plinko.app.protocol.visitors import AppearMessage
from plinko.engine import json_text
from plinko.engine.errors import shorten
from plinko.engine.json_text import Json


class DropMessage(msgspec.Struct, frozen=True, tag="drop", forbid_unknown_fields=True):
    """Ask for a drop.

    The values are any JSON here; their own parsers check them later and name invalid ones.
    key: the `key` of an earlier hello, if the client repeats a drop with the same `ref` from then.
    """

    seed: Json = None
    x: Json = None
    aim: Json = None
    ref: Json = None
    stake: Json = None
    who: Json = None
    session: str | None = None
    key: str | None = None
    name: Json = None
    colour: Json = None


class SessionMessage(msgspec.Struct, frozen=True, tag="session", forbid_unknown_fields=True):
    """Begin a fair session with a `commitment`, or join one by its id and `token`."""

    commitment: Json = None
    session: str | None = None
    token: str | None = None
    ref: Json = None


class OpenMessage(msgspec.Struct, frozen=True, tag="open", forbid_unknown_fields=True):
    """Reveal the secret `seed` of a session's commitment, 64 hexadecimal digits."""

    session: str
    seed: Json
    ref: Json = None


class EndMessage(msgspec.Struct, frozen=True, tag="end", forbid_unknown_fields=True):
    """End a fair session: the server reveals its secret."""

    session: str
    ref: Json = None


class PingMessage(msgspec.Struct, frozen=True, tag="ping", forbid_unknown_fields=True):
    """Ask for the server's clock; the answer repeats `t`."""

    t: float


class ResumeMessage(msgspec.Struct, frozen=True, tag="resume", forbid_unknown_fields=True):
    """Ask for the events that a lost connection missed: those after number `since` of `run`."""

    run: str
    since: int
    key: str = ""


SessionRequest = SessionMessage | OpenMessage | EndMessage

Message = (
    DropMessage
    | PingMessage
    | ResumeMessage
    | SessionMessage
    | OpenMessage
    | EndMessage
    | AppearMessage
    | Change
    | WatchMessage
    | ClaimMessage
)


class _Typed(msgspec.Struct):
    """The field that every message has."""

    type: str


_KINDS: Final[dict[object, type[Message]]] = {
    kind.__struct_config__.tag: kind for kind in get_args(Message)
}


def decode_message(data: str | bytes) -> Message:
    """Parse a client's text message.

    Raises JsonSyntaxError, JsonValueError, MalformedError if the JSON does not have the fields of a
    message, and UnknownMessageError for an unknown `type`.
    """
    value = json_text.parse(data)
    kind = value.get("type") if isinstance(value, dict) else None
    if isinstance(kind, str) and kind not in _KINDS:
        known = ", ".join(map(str, _KINDS))
        raise UnknownMessageError(f"type {shorten(kind)} is not one of: {known}", field="type")
    try:
        if not isinstance(kind, str):
            msgspec.convert(value, _Typed)  # raises an error that says what is missing
        message: Message = msgspec.convert(value, _KINDS[kind])
    except msgspec.ValidationError as error:
        raise MalformedError(str(error)) from None
    return message


def peek(data: str | bytes, key: str) -> object:
    """Field `key` of a message that may be invalid; None if it has no such field."""
    text = data if isinstance(data, str) else data.decode(errors="replace")
    if json_text.too_deep(text):
        return None
    try:
        value = msgspec.json.decode(data)
    except ValueError:
        return None
    return value.get(key) if isinstance(value, dict) else None


def parse_place(value: object, field: str) -> float | None:
    """A start or an aim in m, or None; raises InvalidValueError if it is not a finite number."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidValueError(f"{field} {shorten(value)} is not a number of metres", field=field)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InvalidValueError(
            f"{field} {shorten(value)} is not a finite number of metres", field=field
        )
    return number + 0.0  # turns -0.0 into 0.0


def parse_stream(value: str | None) -> str:
    """The requested stream, by default snapshots; raises InvalidValueError for an unknown one."""
    stream = value or SNAPSHOTS
    if stream == "segments":
        raise InvalidValueError(
            "stream 'segments' ended with protocol 1: use 'paths', which sends each flight whole",
            field="stream",
        )
    if stream not in STREAMS:
        known = ", ".join(STREAMS)
        raise InvalidValueError(f"stream {shorten(value)} is not one of: {known}", field="stream")
    return stream


def parse_protocol(value: str | None) -> None:
    """Check the version that a client states; raises InvalidValueError for another than ours."""
    if value not in (None, str(PROTOCOL_VERSION)):
        raise InvalidValueError(
            f"protocol {shorten(value)} is not {PROTOCOL_VERSION}, the version of this server: its "
            "hello has no spin_scale, and the stream 'paths' replaces 'segments'",
            field="protocol",
        )


def parse_watch(value: str | None) -> bool:
    """Whether the client will only watch; raises InvalidValueError unless None or "true"."""
    if value not in (None, "true"):
        raise InvalidValueError(
            f"watch {shorten(value)} is not 'true': leave it out", field="watch"
        )
    return value is not None
