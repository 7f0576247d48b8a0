"""The fields of a board's JSON form with ranges, units and defaults: one table for all readers.

values.py checks by it, json_form.py reads by it, and the OpenAPI schema is made from it. Pages read
a copy, static/js/solver/input/form.js, which `make readme` writes.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from plinko.engine.board.fields import DEFAULT_HEIGHT, DEFAULT_WIDTH
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec
from plinko.engine.constants import EARTH_GRAVITY

MAX_BINS: Final = 1_000
MAX_NAME: Final = 100
"""Characters."""

MAX_LABEL: Final = 40
"""Characters, after NFC."""

COLOUR: Final = "^#[0-9a-f]{6}$"

MAX_COORDINATE: Final = 1e6
"""m. At larger coordinates, the spacing of float64 values approaches a micrometre."""

MIN_RADIUS: Final = 1e-6
"""m. The square of a smaller radius would be lost in the rounding of squared distances."""

MAX_RADIUS: Final = 1e4
MAX_FRICTION: Final = 10.0
"""Rubber on rubber is near 1. Beyond ten, the motion hardly changes and only rounding grows."""

MAX_DRAG: Final = 1e3
"""1/s. At this limit a ball on Earth falls one centimetre per second."""


class Field(NamedTuple):
    """A number, or a list of at most `most` numbers; without a range something else."""

    name: str
    low: float = -MAX_COORDINATE
    high: float = MAX_COORDINATE
    unit: str = "m"
    default: float | None = None  # None: the field is required, or its default is not a number
    text: str = "In metres."  # for OpenAPI
    most: int = 0  # items of a list
    why: str = ""  # the reason for the range, in errors

    @property
    def rule(self) -> str:
        """What is right, for errors."""
        more = "greater than 0, " if self.low > 0.0 else ""
        unit = f" {self.unit}" if self.unit else ""
        return f"it must be {more}from {self.low:g} to {self.high:g}{unit}{self.why}"


def _other(name: str, most: int = 0) -> Field:
    """A part, a list of parts, or a text of at most `most` characters."""
    return Field(name, 0.0, 0.0, "", text="", most=most)


_SIZE: Final = Field(
    "width", MIN_RADIUS, 2 * MAX_COORDINATE, text="Of the board's picture, in metres."
)
_RADIUS: Final = Field("radius", MIN_RADIUS, MAX_RADIUS)
_LENGTH: Final = Field("jitter", 0.0)
_BALL: Final = BallSpec()


def _surface(of: BallSpec | Material) -> tuple[Field, Field]:
    text = "Speed after a head-on impact, divided by speed before it."
    return (
        Field("restitution", 0.0, 1.0, "", of.restitution, text),
        Field("friction", 0.0, MAX_FRICTION, "", of.friction, "Coulomb's coefficient."),
    )


FORM: Final[Mapping[str, tuple[Field, ...]]] = {
    "board": (
        _other("name", MAX_NAME),
        _SIZE._replace(default=DEFAULT_WIDTH),
        _SIZE._replace(name="height", default=DEFAULT_HEIGHT),
        Field(
            "gravity", 1e-6, 1e4, "m/s^2", EARTH_GRAVITY, "In m/s^2, down.",
            why=", pointing down, or no ball would ever reach a bin",
        ),
        Field("drag", 0.0, MAX_DRAG, "1/s", 0.0, "Linear drag of the air, in 1/s."),
        _other("ball"),
        _other("pegs", 20_000),
        _other("peg_material"),
        _other("walls", 2_000),
        _other("wall_material"),
        _other("bins"),
        _other("drop"),
    ),
    "ball": (
        _RADIUS._replace(default=_BALL.radius),
        Field("density", 1e-9, 1e9, "kg/m^2", _BALL.density, "In kg/m^2."),
        *_surface(_BALL),
    ),
    "peg": (Field("x"), Field("y"), _RADIUS),
    "wall": (Field("x1"), Field("y1"), Field("x2"), Field("y2")),
    "material": _surface(Material()),
    "bins": (
        Field("y"),
        Field("edges", most=MAX_BINS + 1),
        Field("multipliers", 0.0, 1e9, "", most=MAX_BINS),
        _other("labels", MAX_BINS),
    ),
    "label": (_other("text", MAX_LABEL), _other("colour")),
    "drop": (
        Field("x", default=0.0),
        Field("y", default=0.0),
        _LENGTH._replace(default=0.0, text="The offset is from -jitter to jitter, m."),
        Field("slots", text="If given, the only places to aim at, m.", most=1_000),
        _LENGTH._replace(
            name="reach", default=0.0,
            text="How far from `x` a ball may start, m, if that is more than `jitter`.",
        ),
        _LENGTH._replace(
            name="aim", default=0.0, text="How far from `x` a player may aim, m."
        ),
    ),
}  # fmt: skip
"""The fields of a board and of its parts by their names, in the order of its digest."""


def names(part: str) -> tuple[str, ...]:
    return tuple(field.name for field in FORM[part])


def field_of(part: str, name: str) -> Field:
    return next(field for field in FORM[part] if field.name == name)
