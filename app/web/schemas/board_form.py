"""The JSON form of a board for OpenAPI: each field with its unit, range and default.

These types only describe it: `plinko.engine.board.json_form` reads boards and names what is wrong.
A test checks every preset, default and range against this description.
"""

from typing import Annotated

import msgspec
from msgspec import UNSET, Meta, UnsetType

from plinko.engine.board import values
from plinko.engine.board.fields import DEFAULT_HEIGHT, DEFAULT_WIDTH
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, DropZone
from plinko.engine.constants import EARTH_GRAVITY

_BALL, _SURFACE, _ZONE = BallSpec(), Material(), DropZone()
_MOST = values.MAX_COORDINATE

Coordinate = Annotated[float, Meta(ge=-_MOST, le=_MOST, description="In metres.")]
Radius = Annotated[
    float, Meta(ge=values.MIN_RADIUS, le=values.MAX_RADIUS, description="In metres.")
]
Restitution = Annotated[
    float,
    Meta(ge=0.0, le=1.0, description="Speed after a head-on impact, divided by speed before it."),
]
Friction = Annotated[
    float, Meta(ge=0.0, le=values.MAX_FRICTION, description="Coulomb's coefficient.")
]
Distance = Annotated[float, Meta(ge=0.0, le=_MOST, description="In metres.")]
Size = Annotated[
    float,
    Meta(ge=values.MIN_RADIUS, le=2 * _MOST, description="Of the board's picture, in metres."),
]

Multiplier = Annotated[float, Meta(ge=0.0, le=values.MAX_MULTIPLIER)]


class BallForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ball: a disc. An impact uses the greater restitution of the two bodies."""

    radius: Radius = _BALL.radius
    density: Annotated[
        float, Meta(ge=values.MIN_DENSITY, le=values.MAX_DENSITY, description="In kg/m^2.")
    ] = _BALL.density
    restitution: Restitution = _BALL.restitution
    friction: Friction = _BALL.friction


class PegForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A disc that does not move. Pegs do not overlap."""

    x: Coordinate
    y: Coordinate
    radius: Radius


class WallForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A segment without thickness, hit from either side and at its ends."""

    x1: Coordinate
    y1: Coordinate
    x2: Coordinate
    y2: Coordinate


class MaterialForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The material of pegs or walls."""

    restitution: Restitution = _SURFACE.restitution
    friction: Friction = _SURFACE.friction


class LabelForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A bin's label: the prize that a ball in it wins."""

    text: Annotated[
        str,
        Meta(
            min_length=1,
            max_length=values.MAX_LABEL,
            description="Letters, marks, digits, symbols and single spaces; stored in NFC.",
        ),
    ]
    colour: Annotated[
        Annotated[str, Meta(pattern=values.COLOUR)] | None,
        Meta(description="#rrggbb; default: the colour of the bin's multiplier."),
    ] = None


class BinsForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where a drop ends: bin i spans edges[i] to edges[i + 1] at `y` and pays multipliers[i]."""

    y: Annotated[
        Annotated[float, Meta(ge=-_MOST, le=_MOST)] | UnsetType,
        Meta(description="In metres; default: the board's `height`."),
    ] = UNSET
    edges: Annotated[
        Annotated[list[Coordinate], Meta(min_length=2, max_length=values.MAX_BINS + 1)] | UnsetType,
        Meta(description="Rising, in metres; default: bins of equal width across the `width`."),
    ] = UNSET
    multipliers: Annotated[
        Annotated[list[Multiplier], Meta(max_length=values.MAX_BINS)] | UnsetType,
        Meta(description="One for each bin: the payout for a stake of 1. Default: 1 each."),
    ] = UNSET
    labels: Annotated[
        list[LabelForm | None],
        Meta(max_length=values.MAX_BINS, description="One or null for each bin; default: none."),
    ] = []


class DropForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where a ball starts, at rest: at `y`, and at `x` plus an offset drawn from the seed."""

    x: Coordinate = _ZONE.x
    y: Coordinate = _ZONE.y
    jitter: Annotated[Distance, Meta(description="The offset is from -jitter to jitter, m.")] = (
        _ZONE.jitter
    )
    slots: Annotated[
        list[Coordinate],
        Meta(max_length=values.MAX_SLOTS, description="If given, the only places to aim at, m."),
    ] = []
    reach: Annotated[
        Distance,
        Meta(description="How far from `x` a ball may start, m, if that is more than `jitter`."),
    ] = _ZONE.reach
    aim: Annotated[Distance, Meta(description="How far from `x` a player may aim, m.")] = _ZONE.aim


class BoardForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A board: everything but the seed that decides a ball's path. x points right, y down."""

    name: Annotated[
        str, Meta(min_length=1, max_length=values.MAX_NAME, description="Printable characters.")
    ] = "board"
    width: Size = DEFAULT_WIDTH
    height: Size = DEFAULT_HEIGHT
    gravity: Annotated[
        float, Meta(ge=values.MIN_GRAVITY, le=values.MAX_GRAVITY, description="In m/s^2, down.")
    ] = EARTH_GRAVITY
    drag: Annotated[
        float, Meta(ge=0.0, le=values.MAX_DRAG, description="Linear drag of the air, in 1/s.")
    ] = 0.0
    ball: BallForm = msgspec.field(default_factory=BallForm)
    pegs: Annotated[list[PegForm], Meta(max_length=values.MAX_PEGS)] = []
    peg_material: MaterialForm = msgspec.field(default_factory=MaterialForm)
    walls: Annotated[
        Annotated[list[WallForm], Meta(max_length=values.MAX_WALLS)] | UnsetType,
        Meta(
            description="Default: two walls at the outer edges of the bins, from above the start "
            "down. An empty list: no walls."
        ),
    ] = UNSET
    wall_material: MaterialForm = msgspec.field(default_factory=MaterialForm)
    bins: BinsForm = msgspec.field(default_factory=BinsForm)
    drop: DropForm = msgspec.field(default_factory=DropForm)
