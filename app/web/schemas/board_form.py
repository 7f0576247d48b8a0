"""The JSON form of a board as OpenAPI describes it: each field with its unit, range and default.

Only described here: boards are read by `engine.board.json_form`, which names what is wrong. A test
holds every preset, every default and every range to this.
"""

from typing import Annotated

import msgspec
from msgspec import UNSET, Meta, UnsetType

from engine.board import values
from engine.board.fields import DEFAULT_HEIGHT, DEFAULT_WIDTH
from engine.board.materials import Material
from engine.board.parts import BallSpec, DropZone
from engine.constants import EARTH_GRAVITY

_BALL, _SURFACE, _ZONE = BallSpec(), Material(), DropZone()
_MOST = values.MAX_COORDINATE

Coordinate = Annotated[float, Meta(ge=-_MOST, le=_MOST, description="In metres.")]
Radius = Annotated[
    float, Meta(ge=values.MIN_RADIUS, le=values.MAX_RADIUS, description="In metres.")
]
Restitution = Annotated[
    float, Meta(ge=0.0, le=1.0, description="Speed after a head-on impact over speed before it.")
]
Friction = Annotated[
    float, Meta(ge=0.0, le=values.MAX_FRICTION, description="Coulomb's coefficient.")
]
Distance = Annotated[float, Meta(ge=0.0, le=_MOST, description="In metres.")]
Size = Annotated[
    float, Meta(ge=values.MIN_RADIUS, le=2 * _MOST, description="Of the picture, in metres.")
]

Multiplier = Annotated[float, Meta(ge=0.0, le=values.MAX_MULTIPLIER)]


class BallForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The ball: a disc. In an impact the greater restitution of the two counts."""

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
    """What pegs or walls are made of."""

    restitution: Restitution = _SURFACE.restitution
    friction: Friction = _SURFACE.friction


class LabelForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a bin is called: the prize that a ball in it wins."""

    text: Annotated[
        str,
        Meta(
            min_length=1,
            max_length=values.MAX_LABEL,
            description="Letters, marks, figures, signs and single spaces; kept in NFC.",
        ),
    ]
    colour: Annotated[
        Annotated[str, Meta(pattern=values.COLOUR)] | None,
        Meta(description="#rrggbb; the colour of what the bin pays if left out."),
    ] = None


class BinsForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where a drop ends: bin i spans edges[i] to edges[i + 1] at `y` and pays multipliers[i]."""

    y: Annotated[
        Annotated[float, Meta(ge=-_MOST, le=_MOST)] | UnsetType,
        Meta(description="In metres; the board's `height` if left out."),
    ] = UNSET
    edges: Annotated[
        Annotated[list[Coordinate], Meta(min_length=2, max_length=values.MAX_BINS + 1)] | UnsetType,
        Meta(description="Rising, in metres; they share the `width` equally if left out."),
    ] = UNSET
    multipliers: Annotated[
        Annotated[list[Multiplier], Meta(max_length=values.MAX_BINS)] | UnsetType,
        Meta(description="One a bin, times the stake; 1 each if left out."),
    ] = UNSET
    labels: Annotated[
        list[LabelForm | None],
        Meta(max_length=values.MAX_BINS, description="One a bin or null; none if left out."),
    ] = []


class DropForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where a ball starts, at rest: at `y`, and at `x` plus an offset that the seed decides."""

    x: Coordinate = _ZONE.x
    y: Coordinate = _ZONE.y
    jitter: Annotated[Distance, Meta(description="The offset is from -jitter to jitter, m.")] = (
        _ZONE.jitter
    )
    slots: Annotated[
        list[Coordinate],
        Meta(max_length=values.MAX_SLOTS, description="The only places to aim at, m."),
    ] = []
    reach: Annotated[
        Distance, Meta(description="How far from `x` a ball may start, m, if farther.")
    ] = _ZONE.reach
    aim: Annotated[Distance, Meta(description="How far from `x` a player may aim, m.")] = _ZONE.aim


class BoardForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A board: all that decides where a ball goes, besides its seed. x to the right, y down."""

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
            description="If left out, the outer edges of the bins are walls from above the start "
            "down; an empty list is a board without."
        ),
    ] = UNSET
    wall_material: MaterialForm = msgspec.field(default_factory=MaterialForm)
    bins: BinsForm = msgspec.field(default_factory=BinsForm)
    drop: DropForm = msgspec.field(default_factory=DropForm)
