"""The types of a kernel's arguments and results, as recorded in an artifact, and a call's memory.

A type is a text: numpy's name of a number's type, such as "f8", "i8" or "b1"; and "f8:2" for an
array of two dimensions. Tuples count as their parts.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

ARRAY: Final = 5
"""Numbers that numba's code takes for an array, before its shape and strides."""

HEAP: Final = 8
"""Address of the address from which on kernels allocate arrays."""

STATUS: Final = 16
"""Address of numba's status code of the last call, 4 bytes."""

FINE: Final = (0, -2)
"""Numba's status codes for success, with and without a result."""

BLOCK: Final = 4 * 65_536
"""Address of a call's arguments; its results follow them. LLVM's stack lies below."""


class Signature(NamedTuple):
    """The types of a kernel's arguments, in order, and of its results."""

    takes: Sequence[str]
    gives: Sequence[str]


def dimensions(kind: str) -> int:
    """The dimensions of an array of this type; 0 for a number."""
    return int(kind.partition(":")[2] or 0)


def flat(values: Sequence[Any]) -> Iterator[Any]:
    """All values in nested tuples, in order."""
    for each in values:
        if isinstance(each, tuple):
            yield from flat(each)
        else:
            yield each


def block_format(takes: Sequence[str]) -> str:
    """The format of a block's numbers for `struct`."""
    return "<" + "".join(map(_format, takes))


def _format(kind: str) -> str:
    if dimensions(kind):
        return f"{ARRAY + 2 * dimensions(kind)}q"
    return "d" if kind == "f8" else "q"
