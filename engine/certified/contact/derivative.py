"""The derivative of a contact's state with respect to its start.

It has three components: p, of the way
along the surface, and those of the speed and the spin. The derivative of the normal is kappa p
times the tangent. They obey a linear equation v' = A(s) v, whose solution is the Peano-Baker
series. With A enclosed over a stretch, its j-th term lies in (s^j / j!) A^j v, and the remainder is
bounded by norms (Coddington and Levinson, Theory of Ordinary Differential Equations, 1955, 3.1).
"""

from functools import reduce
from math import factorial
from typing import NamedTuple

from flint import arb

from plinko.engine.certified.balls import ONE, ZERO
from plinko.engine.certified.contact.series import ROLLING, SLIDING, Stretch

_PIECES = 4
"""Pieces of a stretch, at least. Each encloses A separately, which is sharper."""

_TERMS = 16
"""Terms of the Peano-Baker series."""


class Parting(NamedTuple):
    """A ball's derivative with respect to the start, at an event, which each ball reaches at its
    own time: of that time, the way along the surface, the speeds off and along it, and the spin."""

    time: arb
    way: arb
    off: arb
    along: arb
    omega: arb


class Variation:
    """The linear equation v' = A v, with the normal and the speed enclosed in balls."""

    def __init__(self, stretch: Stretch, nx: arb, ny: arb, u: arb) -> None:
        self.law, mode = stretch.law, stretch.start.mode
        self.rolls = mode == ROLLING
        self.share = ONE / 3 * 2 if self.rolls else ONE
        slides = mode == SLIDING
        self.grip = stretch.start.slip_sign * self.law.friction if slides else ZERO
        self.nx, self.ny, self.u = nx, ny, u

    def force(self, way: arb, u: arb) -> arb:
        """The change of the normal force by changes of the way and the speed."""
        return -self.law.curvature * (self.law.gravity * self.nx * way + 2 * self.u * u)

    def drive(self, way: arb, u: arb) -> arb:
        """The change of the force along the surface without friction."""
        return -self.law.gravity * self.law.curvature * self.ny * way - self.law.drag * u

    def change(self, way: arb, u: arb) -> tuple[arb, arb, arb]:
        """A v: the rates of the derivatives of way, speed and spin, the last times the radius."""
        grip = self.grip * self.force(way, u)
        faster = self.share * self.drive(way, u) - grip
        return u, faster, faster if self.rolls else 2 * grip

    def norm(self) -> arb:
        """Upper bound of A in the norm of the largest component."""
        rows = zip(self.change(ONE, ZERO), self.change(ZERO, ONE), strict=True)
        return reduce(arb.max, (abs(a) + abs(b) for a, b in rows))


def carried(stretch: Stretch, share: arb, parting: Parting) -> Parting:
    """The derivatives at the time `share` of a stretch, which is the same time for all balls."""
    pieces = max(_PIECES, int(2.0 * float(stretch.law.drag * share) * stretch.unit))
    step = share / pieces * arb(stretch.unit)
    for i in range(pieces):
        piece = (share * i / pieces).union(share * (i + 1) / pieces)
        enclosed = (series.at(piece) for series in (stretch.nx, stretch.ny, stretch.u))
        variation = Variation(stretch, *enclosed)
        parting = _after(variation, step, parting)
    return parting


def _after(variation: Variation, step: arb, parting: Parting) -> Parting:
    """The derivatives `step` s later; `variation` encloses A until then."""
    term = parting.way, parting.along, parting.omega * variation.law.radius
    size = reduce(arb.max, map(abs, term))
    sums = list(term)
    for j in range(1, _TERMS):
        way, along, spin = variation.change(term[0], term[1])
        term = way * step / j, along * step / j, spin * step / j
        sums = [a + b for a, b in zip(sums, term, strict=True)]
    growth = variation.norm() * abs(step)
    rest = arb(0, (size * growth**_TERMS / factorial(_TERMS) * growth.exp()).abs_upper())
    way, along, spin = (part + rest for part in sums)
    return parting._replace(way=way, along=along, omega=spin / variation.law.radius)
