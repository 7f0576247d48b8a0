"""Materials of balls, pegs and walls: restitution, friction, and how a contact combines two."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple


@dataclass(frozen=True, slots=True)
class Material:
    """A surface. `Board` checks the values.

    restitution: speed after a head-on impact over speed before it, 0 (clay) to 1 (no loss).
    friction: Coulomb's coefficient, 0 or more, the same for static and sliding friction.
    """

    restitution: float = 0.6
    friction: float = 0.0


def combine(a: Material, b: Material) -> Material:
    """Return the material of a contact: larger restitution, geometric mean of the frictions.

    These are Box2D's rules. With the geometric mean, a frictionless body has no friction with any
    other. sqrt is correctly rounded, so every machine computes the same bits.
    """
    return Material(
        restitution=max(a.restitution, b.restitution),
        friction=math.sqrt(a.friction * b.friction),
    )


REFERENCE_DENSITY: Final = 80.0
"""Density of the presets' balls, kg/m^2: 0.008 kg per square pixel at 100 pixels per metre."""


class RestitutionRange(NamedTuple):
    """A pair of bodies and the range of restitution measured for it."""

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
"""Measured ranges for head-on impacts; the first row is the possible range."""

GRAVITY: Final[Mapping[str, float]] = {"Earth": 9.81, "Moon": 1.62, "Mars": 3.72, "Jupiter": 24.79}
"""m/s^2 at the surface; for Jupiter, at the top of its clouds."""
