"""Parses JSON strictly: refuses text that two readers could understand differently.

Refused are: duplicate keys, of which readers keep different ones; NaN and Infinity, which are not
JSON; numbers beyond float64, which would become infinite; lone surrogates, which cannot be encoded
as UTF-8; and more than `DEEPEST` levels, which could be parsed here, but exceed Python's recursion
limit when they are written from deeper in the call stack. An error has the path of the value.
"""

import json
import math
import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Final

from plinko.engine.errors import JsonSyntaxError, JsonValueError

DEEPEST: Final = 64
"""Most levels of nested brackets."""

Json = Any
"""A JSON value that has not been validated yet."""

JsonObject = Mapping[str, Json]
"""A JSON object whose values have not been validated yet."""

LARGEST: Final = 1 << 30
"""Most bytes of a file: such a text of numbers takes a machine's memory once it is parsed."""

_STRINGS: Final = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)
_BRACKETS: Final = re.compile(r"[\[\]{}]")
_HALF_PAIR: Final = re.compile(r"\\u[dD][89a-fA-F]")
# Only texts that match these can have a number out of range. All others are left to the parser's
# own number functions, which are faster.
_LONG: Final = re.compile(r"\d{300}")
_EXPONENT_OR_LONG: Final = re.compile(r"\d[eE]|\d{300}")
_LONGEST_PLACE: Final = 100  # characters of a path in an error


class _Fault:
    """Replaces a refused value while the text is parsed, because its path is only known later."""

    def __init__(self, why: str) -> None:
        self.why = why


def read_text(file: str | os.PathLike[str] | BinaryIO, largest: int = LARGEST) -> str:
    """Read a text file in UTF-8, or in UTF-16 or UTF-32, in which PowerShell redirects output.

    file: a path or an open file. Raises OSError if it cannot be read, and JsonSyntaxError if it has
    more than `largest` bytes, which are then not parsed, or is not text.
    """
    if isinstance(file, str | os.PathLike):
        with Path(file).open("rb") as opened:
            return read_text(opened, largest)
    raw = file.read(largest + 1)
    if len(raw) > largest:
        raise JsonSyntaxError(f"too large: it has more than {largest:,} bytes")
    return decode(raw)


def decode(raw: bytes) -> str:
    """Decode text, whose encoding shows in its first bytes; JsonSyntaxError if it is not text."""
    encoding = json.detect_encoding(raw)
    try:
        return raw.decode(encoding)
    except UnicodeDecodeError as error:
        name = "-".join(encoding.upper().split("-")[:2])
        raise JsonSyntaxError(f"not {name} text: {error.reason}") from None


def parse(text: str | bytes) -> Any:
    """Parse JSON text; bytes are UTF-8.

    Raises JsonSyntaxError if it is not JSON or nested too deeply, and JsonValueError for a refused
    value, whose path, such as `pegs[0].radius`, is the error's `field`.
    """
    if isinstance(text, bytes):
        try:
            text = text.decode()
        except UnicodeDecodeError as error:
            raise JsonSyntaxError(f"not JSON: not UTF-8: {error.reason}") from None
    if too_deep(text):
        raise JsonSyntaxError(f"JSON nested too deeply: more than {DEEPEST} levels")
    faults: list[_Fault] = []

    def fault(why: str) -> _Fault:
        faults.append(_Fault(why))
        return faults[-1]

    def constant(name: str) -> Any:
        return fault(f"{name} is not a JSON number")

    def real(digits: str) -> Any:
        value = float(digits)
        return value if math.isfinite(value) else fault(f"{_short(digits)} is out of range")

    def whole(digits: str) -> Any:
        if math.isfinite(float(digits)):
            return int(digits)
        return fault(f"a number of {len(digits.lstrip('-'))} digits is out of range")

    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            counts = Counter(key for key, _ in pairs)
            twice = next(key for key, count in counts.items() if count > 1)
            found[twice] = fault("the key is given twice")
        return found

    try:
        value = json.loads(
            text,
            parse_constant=constant,
            parse_float=real if _EXPONENT_OR_LONG.search(text) else None,
            parse_int=whole if _LONG.search(text) else None,
            object_pairs_hook=members,
        )
    except json.JSONDecodeError as error:
        raise JsonSyntaxError(f"not JSON: {error}") from None
    if faults or _HALF_PAIR.search(text):
        for place, why in _faults(value, ""):
            raise JsonValueError(f"{place or 'the value'}: {why}", field=place)
    return value


def too_deep(text: str) -> bool:
    """Whether brackets are nested deeper than `DEEPEST`."""
    if text.count("[") + text.count("{") <= DEEPEST:
        return False
    depth = 0
    for bracket in _BRACKETS.findall(_STRINGS.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        if depth > DEEPEST:
            return True
    return False


def _faults(value: Any, place: str) -> Iterator[tuple[str, str]]:
    """Yield the path of every refused value and the reason, in the order of the text."""
    match value:
        case _Fault():
            yield place, value.why
        case str() if _has_surrogate(value):
            yield place, f"{ascii(value)[:40]} has a lone surrogate, which is not a character"
        case list():
            for number, item in enumerate(value):
                yield from _faults(item, f"{place}[{number}]")
        case dict():
            for key, item in value.items():
                name = key.encode("utf-8", "backslashreplace").decode()
                inner = f"{place}.{name}"[:_LONGEST_PLACE] if place else name[:_LONGEST_PLACE]
                if _has_surrogate(key):
                    yield inner, "the key has a lone surrogate, which is not a character"
                yield from _faults(item, inner)


def _has_surrogate(text: str) -> bool:
    return any("\ud800" <= character <= "\udfff" for character in text)


def _short(digits: str) -> str:
    return digits if len(digits) <= 40 else f"{digits[:37]}..."
