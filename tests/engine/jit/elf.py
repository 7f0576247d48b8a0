"""Reads what a Linux shared library needs from its loader and from other libraries.

The native kernels must need nothing, so that they run on every machine of their kind.
"""

import struct
from collections.abc import Iterator
from typing import NamedTuple

_HEADER = struct.Struct("<16sHHIQQQIHHHHHH")
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_ENTRY = struct.Struct("<qQ")

_RELOCATIONS = {4, 9, 19}  # section types RELA, REL, RELR
_DYNAMIC = 6
_DYNAMIC_SYMBOLS = 11
# Entries of the dynamic section.
_NEEDED = 1  # another library
_FUNCTIONS_CALLED = {12, 13, 25, 26}  # functions that run on loading or unloading


class Section(NamedTuple):
    kind: int
    content: bytes


def sections(library: bytes) -> Iterator[Section]:
    """All sections. Raises ValueError unless it is a 64-bit little-endian ELF file."""
    if library[:6] != b"\x7fELF\x02\x01":
        raise ValueError(f"{library[:6]!r} is not how a library of 64 bits begins")
    header = _HEADER.unpack_from(library)
    at, count = header[6], header[12]
    for number in range(count):
        _, kind, _, _, begin, size, *_ = _SECTION.unpack_from(library, at + number * _SECTION.size)
        yield Section(kind, library[begin : begin + size])


def asks_for(library: bytes) -> list[str]:
    """What the library needs in addition to its own bytes, in words; empty if nothing."""
    found = []
    for kind, content in sections(library):
        if kind in _RELOCATIONS and content:
            found.append(f"{len(content)} bytes of relocations")
        elif kind == _DYNAMIC_SYMBOLS:
            undefined = [s for s in _SYMBOL.iter_unpack(content) if s[3] == 0][1:]
            found += [f"{len(undefined)} imports"] if undefined else []
        elif kind == _DYNAMIC:
            tags = {tag for tag, _ in _ENTRY.iter_unpack(content)}
            found += ["other libraries"] if _NEEDED in tags else []
            found += ["functions to run as it is loaded"] if tags & _FUNCTIONS_CALLED else []
    return found
