"""What a client accepts: the headers Accept, Accept-Encoding, Accept-Language (RFC 9110, 12). Pure.

Names are compared without regard to case, a weight (`q`) of 0 refuses, and `*` stands for what is
not listed.
"""

import functools
import re
from collections.abc import Mapping
from typing import Final

from starlette.datastructures import Headers

_OUTSIDE_QUOTES = r'(?:[^{0}"]|"(?:[^"\\]|\\.)*"?)+'
_ENTRY: Final = re.compile(_OUTSIDE_QUOTES.format(","))
_PART: Final = re.compile(_OUTSIDE_QUOTES.format(";"))
_WEIGHT: Final = re.compile(r"q\s*=\s*(0(?:\.\d{0,3})?|1(?:\.0{0,3})?)", re.ASCII | re.IGNORECASE)


def whole(headers: Headers, name: str) -> str:
    """A header that lists something: several lines of it are one list."""
    return ", ".join(headers.getlist(name))


def weights(header: str) -> dict[str, float]:
    """The weight, 0 to 1, of each name in a header, in lower case; other parameters are ignored.

    An invalid weight counts as none, which is 1. Of a name listed twice, the larger weight counts.
    """
    found: dict[str, float] = {}
    for entry in _ENTRY.findall(header):
        name, *parameters = [part.strip() for part in _PART.findall(entry)] or [""]
        given = [match for each in parameters if (match := _WEIGHT.fullmatch(each))]
        weight = float(given[0][1]) if given else 1.0
        if name:
            found[name.lower()] = max(weight, found.get(name.lower(), 0.0))
    return found


@functools.lru_cache(maxsize=256)
def accepts_gzip(header: str) -> bool:
    """Whether a client prefers a compressed response, or likes it as much as a plain one."""
    known = weights(header)
    gzip = max(known.get("gzip", -1.0), known.get("x-gzip", -1.0))
    if gzip < 0.0:
        gzip = known.get("*", 0.0)
    return gzip > 0.0 and gzip >= known.get("identity", 0.0)


@functools.lru_cache(maxsize=256)
def accepts_brotli(header: str) -> bool:
    """Whether a client names Brotli, and likes it as much as gzip and a plain response."""
    known = weights(header)
    others = (known.get(name, 0.0) for name in ("gzip", "identity"))
    return known.get("br", 0.0) > 0.0 and known["br"] >= max(others)


def asks_for(header: str, media_type: str, default: str = "") -> bool:
    """Whether a client names `media_type` and wants it as much as `default`, or more.

    `*/*` names nothing: programs send it that take what they get.
    """
    known = weights(header)
    named = {name: weight for name, weight in known.items() if name != "*/*"}
    return _weight_of(media_type, named) > 0.0 and (
        _weight_of(media_type, named) >= _weight_of(default, known)
    )


def _weight_of(media_type: str, known: Mapping[str, float]) -> float:
    """The weight of the most specific range that includes the type."""
    ranges = (media_type, f"{media_type.partition('/')[0]}/*", "*/*")
    return next((known[name] for name in ranges if name in known), 0.0)
