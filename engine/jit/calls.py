"""What a kernel's machine code takes and gives, kind by kind, as an artifact says it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, TypeAlias

ARRAY: Final = 5
"""Numbers that numba's code takes of an array ahead of its shape and strides."""

HEAP: Final = 8
"""Where in a module's memory stands where the arrays begin that kernels make themselves."""

STATUS: Final = 16
"""Where numba's code of how a call ended is left: 4 bytes."""

BLOCK: Final = 4 * 65_536
"""Where the block of a call begins, and its results behind it. LLVM's stack ends here."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A number or an array: its values' type as numpy names it, and an array's dimensions."""

    name: str  # f8, i8, b1 …
    dimensions: int | None = None  # None: a number

    @classmethod
    def read(cls, text: str) -> "Kind":
        """Of "f8" for a number, "f8:2" for an array of two dimensions."""
        name, _, dimensions = text.partition(":")
        return cls(name, int(dimensions) if dimensions else None)

    def __str__(self) -> str:
        return self.name if self.dimensions is None else f"{self.name}:{self.dimensions}"


Kinds: TypeAlias = "Kind | tuple[Kinds, ...]"
"""A kind, or those of a tuple."""


class Call(NamedTuple):
    """What a kernel takes, in order, and what it gives: None for nothing."""

    takes: tuple[Kinds, ...]
    gives: "Kinds | None"

    @classmethod
    def read(cls, form: dict[str, Any]) -> "Call":
        """Of its JSON form."""
        return cls(
            tuple(map(_read, form["takes"])),
            None if form["gives"] is None else _read(form["gives"]),
        )

    def to_dict(self) -> dict[str, Any]:
        """Its JSON form: of a tuple a list."""
        gives = None if self.gives is None else _written(self.gives)
        return {"takes": [_written(each) for each in self.takes], "gives": gives}


def _read(form: Any) -> Kinds:
    return Kind.read(form) if isinstance(form, str) else tuple(map(_read, form))


def _written(kinds: Kinds) -> Any:
    return str(kinds) if isinstance(kinds, Kind) else [_written(each) for each in kinds]


def leaves(kinds: Kinds) -> Iterator[Kind]:
    """All kinds in a tuple, and in tuples in it, in order."""
    if isinstance(kinds, Kind):
        yield kinds
        return
    for each in kinds:
        yield from leaves(each)


def flat(values: Sequence[Any]) -> Iterator[Any]:
    """All that is in a tuple, and in tuples in it, in order."""
    for each in values:
        if isinstance(each, tuple):
            yield from flat(each)
        else:
            yield each


def block_format(takes: tuple[Kinds, ...]) -> str:
    """Of the numbers in a block, as `struct` has it."""
    return "<" + "".join(map(_format, leaves(takes)))


def _format(kind: Kind) -> str:
    if kind.dimensions is not None:
        return f"{ARRAY + 2 * kind.dimensions}q"
    return "d" if kind.name == "f8" else "q"
