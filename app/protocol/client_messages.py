"""What a client says in any room, pure: the messages, and bytes as messages or a named error.

What is said only where balls touch each other is in touching_messages.py.
"""

import math
import re
from typing import Any

import msgspec

from app.errors import InvalidValueError, MalformedError, UnknownMessageError, shorten
from app.protocol.messages import SNAPSHOTS, STREAMS
from app.protocol.touching_messages import Change, ClaimMessage, WatchMessage
from app.protocol.visitors import AppearMessage


class DropMessage(msgspec.Struct, frozen=True, tag="drop", forbid_unknown_fields=True):
    """Ask for a ball. `seed`, `x`, `aim` stay as they came: their parsers name what is wrong.

    `key`, that of an earlier hello, says that the same drop, by its `ref`, was asked for then.
    """

    seed: Any = None
    x: Any = None
    aim: Any = None
    ref: Any = None
    stake: Any = None
    who: Any = None
    session: str | None = None
    key: str | None = None


class SessionMessage(msgspec.Struct, frozen=True, tag="session", forbid_unknown_fields=True):
    """Begin a session with a `commitment`, or join one again by its id and `token`."""

    commitment: Any = None
    session: str | None = None
    token: str | None = None
    ref: Any = None


class OpenMessage(msgspec.Struct, frozen=True, tag="open", forbid_unknown_fields=True):
    """Open the secret `seed` that a session's commitment is of, 64 hexadecimal digits."""

    session: str
    seed: Any
    ref: Any = None


class EndMessage(msgspec.Struct, frozen=True, tag="end", forbid_unknown_fields=True):
    """End a session: the server reveals its secret."""

    session: str
    ref: Any = None


class PingMessage(msgspec.Struct, frozen=True, tag="ping", forbid_unknown_fields=True):
    """Ask for the clocks; `t` comes back as it is."""

    t: float


class ResumeMessage(msgspec.Struct, frozen=True, tag="resume", forbid_unknown_fields=True):
    """Ask for what was announced while the connection was broken: after number `since` of `run`."""

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
_DEEPEST = 64  # brackets within brackets
_TOO_DEEP = f"JSON nested too deeply: more than {_DEEPEST} levels"
_BRACKETS = re.compile(r"[\[\]{}]")
_STRINGS = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)

_messages: msgspec.json.Decoder[Message] = msgspec.json.Decoder(Message)
_types = (
    "drop", "ping", "resume", "session", "open", "end", "appear", "add", "kick", "drag",
    "release", "remove", "clear", "edit", "settings", "pause", "step", "reset", "watch", "claim",
)  # fmt: skip


def decode_message(data: str | bytes) -> Message:
    """A client's text message as a value.

    Raises MalformedError for what is not a JSON object of a message's shape, UnknownMessageError
    for a `type` that is none of the protocol's.
    """
    if too_deep(data):
        raise MalformedError(_TOO_DEEP)
    try:
        return _messages.decode(data)
    except msgspec.ValidationError as error:
        kind = peek(data, "type")
        if isinstance(kind, str) and kind not in _types:
            known = ", ".join(_types)
            raise UnknownMessageError(
                f"type {shorten(kind)} is not one of: {known}", field="type"
            ) from None
        raise MalformedError(str(error)) from None
    except (msgspec.DecodeError, UnicodeError) as error:
        raise MalformedError(f"not JSON: {error}") from None


def peek(data: str | bytes, key: str) -> Any:
    """Field `key` of a JSON object that may be no valid message; None when there is none."""
    if too_deep(data):
        return None
    try:
        value = msgspec.json.decode(data)
    except ValueError:
        return None
    return value.get(key) if isinstance(value, dict) else None


def too_deep(data: str | bytes) -> bool:
    """Whether JSON is nested deeper than anyone needs.

    What can just be decoded here could not be encoded again elsewhere, where Python's own stack is
    deeper: a `ref` would come back as a failure of the room.
    """
    text = data if isinstance(data, str) else data.decode(errors="replace")
    if text.count("[") + text.count("{") <= _DEEPEST:
        return False
    depth = 0
    for bracket in _BRACKETS.findall(_STRINGS.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > _DEEPEST:
            return True
    return False


def parse_x(value: object) -> float | None:
    """An explicit start in metres, or None; raises InvalidValueError naming what is no number."""
    return _parse_place(value, "x")


def parse_aim(value: object) -> float | None:
    """A player's aim in metres, or None; raises InvalidValueError naming what is no number."""
    return _parse_place(value, "aim")


def _parse_place(value: object, field: str) -> float | None:
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
    return number + 0.0  # a negative zero is the same place


def parse_stream(value: str | None) -> str:
    """The stream asked for, snapshots if none; raises InvalidValueError for one there is not."""
    stream = value or SNAPSHOTS
    if stream not in STREAMS:
        known = ", ".join(STREAMS)
        raise InvalidValueError(f"stream {shorten(value)} is not one of: {known}", field="stream")
    return stream


def parse_watch(value: str | None) -> bool:
    """Whether a client says that it only watches; raises InvalidValueError for any other value."""
    if value not in (None, "true"):
        raise InvalidValueError(f"watch {shorten(value)} is not true", field="watch")
    return value is not None
