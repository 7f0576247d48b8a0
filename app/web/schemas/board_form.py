"""The JSON form of a board for OpenAPI: each field with its unit, range and default.

These types only describe it: `plinko.engine.board.json_form` reads boards and names what is wrong.
A test checks every preset, default and range against this description.
"""

from typing import Annotated, Any

import msgspec
from msgspec import UNSET, Meta, UnsetType

from plinko.engine.board.form import COLOUR, FORM, Field, field_of


def _number(field: Field) -> Any:
    return Annotated[float, Meta(ge=field.low, le=field.high)]


def _list(field: Field, of: Any, description: str | None = None, least: int = 0) -> Any:
    meta = Meta(min_length=least or None, max_length=field.most, description=description)
    return Annotated[list[of], meta]


def _type(field: Field) -> Any:
    number = _number(field)
    if field.most:
        return _list(field, number, field.text)
    return Annotated[number, Meta(description=field.text)]


def _form(part: str, description: str, **others: Any) -> type[msgspec.Struct]:
    """The type of a part, whose numbers are those of the table; `others` replaces some fields."""
    fields: list[Any] = []
    for field in FORM[part]:
        if field.name in others:
            fields.append((field.name, *others[field.name]))
        elif field.most:
            fields.append((field.name, _type(field), []))
        elif field.default is not None:
            fields.append((field.name, _type(field), field.default))
        else:
            fields.append((field.name, _type(field)))
    return msgspec.defstruct(
        f"{part.capitalize()}Form", fields, namespace={"__doc__": description}, module=__name__,
        frozen=True, forbid_unknown_fields=True,
    )  # fmt: skip


def _default(kind: type[msgspec.Struct]) -> tuple[type[msgspec.Struct], Any]:
    return kind, msgspec.field(default_factory=kind)


def _optional(kind: Any, description: str) -> tuple[Any, Any]:
    return Annotated[kind | UnsetType, Meta(description=description)], UNSET


BallForm = _form(
    "ball", "The ball: a disc. An impact uses the greater restitution of the two bodies."
)
PegForm = _form("peg", "A disc that does not move. Pegs do not overlap.")
WallForm = _form("wall", "A segment without thickness, hit from either side and at its ends.")
MaterialForm = _form("material", "The material of pegs or walls.")
DropForm = _form(
    "drop", "Where a ball starts, at rest: at `y`, and at `x` plus an offset drawn from the seed."
)


class LabelForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A bin's label: the prize that a ball in it wins."""

    text: Annotated[
        str,
        Meta(
            min_length=1,
            max_length=field_of("label", "text").most,
            description="Letters, marks, digits, symbols and single spaces; stored in NFC.",
        ),
    ]
    colour: Annotated[
        Annotated[str, Meta(pattern=COLOUR)] | None,
        Meta(description="#rrggbb; default: the colour of the bin's multiplier."),
    ] = None


BinsForm = _form(
    "bins",
    "Where a drop ends: bin i spans edges[i] to edges[i + 1] at `y` and pays multipliers[i].",
    y=_optional(_number(field_of("bins", "y")), "In metres; default: the board's `height`."),
    edges=_optional(
        _list(field_of("bins", "edges"), _number(field_of("bins", "edges")), least=2),
        "Rising, in metres; default: bins of equal width across the `width`.",
    ),
    multipliers=_optional(
        _list(field_of("bins", "multipliers"), _number(field_of("bins", "multipliers"))),
        "One for each bin: the payout for a stake of 1. Default: 1 each.",
    ),
    labels=(
        _list(
            field_of("bins", "labels"), LabelForm | None, "One or null for each bin; default: none."
        ),
        [],
    ),
)  # fmt: skip

_NAME = Meta(
    min_length=1, max_length=field_of("board", "name").most, description="Printable characters."
)

BoardForm = _form(
    "board",
    "A board: everything but the seed that decides a ball's path. x points right, y down.",
    name=(Annotated[str, _NAME], "board"),
    ball=_default(BallForm),
    pegs=(_list(field_of("board", "pegs"), PegForm), []),
    peg_material=_default(MaterialForm),
    walls=_optional(
        _list(field_of("board", "walls"), WallForm),
        "Default: two walls at the outer edges of the bins, from above the start down. An empty "
        "list: no walls.",
    ),
    wall_material=_default(MaterialForm),
    bins=_default(BinsForm),
    drop=_default(DropForm),
)
