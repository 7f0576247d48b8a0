"""What balls, pegs and walls are made of: restitution, friction, and how a pair combines them."""

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple


@dataclass(frozen=True, slots=True)
class Material:
    """A surface. Its values are checked when a board is made of it.

    restitution: speed after a head-on impact over speed before it, 0 (clay) to 1 (no loss).
    friction: Coulomb's coefficient, static and sliding alike, 0 or more.
    """

    restitution: float = 0.6
    friction: float = 0.0


def combine(a: Material, b: Material) -> Material:
    """Material of the contact between `a` and `b`: the bouncier one, the geometric mean friction.

    The pair rules of Box2D. The geometric mean makes a frictionless body frictionless against
    anything; sqrt is correctly rounded everywhere, so the result has the same bits everywhere.
    """
    return Material(
        restitution=max(a.restitution, b.restitution),
        friction=math.sqrt(a.friction * b.friction),
    )


REFERENCE_DENSITY: Final = 80.0
"""kg/m^2, of the presets' balls: 0.008 a square pixel, drawn at 100 pixels a metre."""


class RestitutionRange(NamedTuple):
    """A row of the restitution table: a pair of bodies and the range measured for it."""

    name: str
    low: float
    high: float
    note: str


RESTITUTION: Final = (
    RestitutionRange("Coefficient of restitution", 0.0, 1.0, "1 is elastic, 0 is inelastic"),
    RestitutionRange("Steel on steel", 0.80, 0.95, "Hardened steel balls"),
    RestitutionRange("Glass on glass", 0.93, 0.97, "Tempered glass spheres"),
    RestitutionRange("Rubber on concrete", 0.75, 0.85, "Standard basketball bounce"),
    RestitutionRange("Tennis ball on court", 0.70, 0.75, "ITF regulation range"),
    RestitutionRange("Clay (putty)", 0.0, 0.10, "Nearly perfectly inelastic"),
    RestitutionRange("Billiard balls", 0.92, 0.98, "Phenolic resin, polished"),
)
"""Measured ranges for head-on impacts of two bodies; the first row is the scale itself."""

GRAVITY: Final = MappingProxyType({"Earth": 9.81, "Moon": 1.62, "Mars": 3.72, "Jupiter": 24.79})
"""m/s^2 at the surface; for Jupiter, where its clouds begin."""
