"""The argument and result types of a kernel's machine code, as recorded in an artifact."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, TypeAlias

ARRAY: Final = 5
"""Numbers that numba's code takes for an array, before its shape and strides."""

HEAP: Final = 8
"""Address of the address from which on kernels allocate arrays."""

STATUS: Final = 16
"""Address of numba's status code of the last call, 4 bytes."""

BLOCK: Final = 4 * 65_536
"""Address of a call's arguments; its results follow them. LLVM's stack lies below."""


@dataclass(frozen=True, slots=True)
class Kind:
    """The type of a number or an array: numpy's name of the values' type, and the dimensions."""

    name: str  # f8, i8, b1 …
    dimensions: int | None = None  # None: a number

    @classmethod
    def read(cls, text: str) -> "Kind":
        """Parse "f8" for a number, "f8:2" for an array of two dimensions."""
        name, _, dimensions = text.partition(":")
        return cls(name, int(dimensions) if dimensions else None)

    def __str__(self) -> str:
        return self.name if self.dimensions is None else f"{self.name}:{self.dimensions}"


Kinds: TypeAlias = "Kind | tuple[Kinds, ...]"
"""A kind, or the kinds of a tuple's parts."""


class Call(NamedTuple):
    """The kinds of a kernel's arguments, in order, and of its result; None for no result."""

    takes: tuple[Kinds, ...]
    gives: "Kinds | None"

    @classmethod
    def read(cls, form: dict[str, Any]) -> "Call":
        return cls(
            tuple(map(_read, form["takes"])),
            None if form["gives"] is None else _read(form["gives"]),
        )

    def to_dict(self) -> dict[str, Any]:
        """The JSON form; tuples become lists."""
        gives = None if self.gives is None else _written(self.gives)
        return {"takes": [_written(each) for each in self.takes], "gives": gives}


def _read(form: Any) -> Kinds:
    return Kind.read(form) if isinstance(form, str) else tuple(map(_read, form))


def _written(kinds: Kinds) -> Any:
    return str(kinds) if isinstance(kinds, Kind) else [_written(each) for each in kinds]


def leaves(kinds: Kinds) -> Iterator[Kind]:
    """All kinds in nested tuples, in order."""
    if isinstance(kinds, Kind):
        yield kinds
        return
    for each in kinds:
        yield from leaves(each)


def flat(values: Sequence[Any]) -> Iterator[Any]:
    """All values in nested tuples, in order."""
    for each in values:
        if isinstance(each, tuple):
            yield from flat(each)
        else:
            yield each


def block_format(takes: tuple[Kinds, ...]) -> str:
    """The format of a block's numbers for `struct`."""
    return "<" + "".join(map(_format, leaves(takes)))


def _format(kind: Kind) -> str:
    if kind.dimensions is not None:
        return f"{ARRAY + 2 * kind.dimensions}q"
    return "d" if kind.name == "f8" else "q"
