"""All starts of an interval at once while they roll or slide: how fast their ways over a surface
part.

The derivative of a contact's state with respect to the start is carried as p, along the surface,
with those of its speed and spin; the normal's is kappa p times the tangent. It obeys the linear
equation v' = A(s) v, whose solution is the Peano-Baker series: with A enclosed over a stretch, the
integral of its j-th term is in (s^j / j!) A^j v, and what is left out is bounded by norms
(Coddington and Levinson, Theory of Ordinary Differential Equations, 1955, 3.1).
"""

from dataclasses import replace
from functools import reduce
from math import factorial
from typing import NamedTuple

from flint import arb

from engine.certified.balls import ONE, ZERO, Proof, UndecidedError
from engine.certified.contact.endings import Cause, Ending, Known, first_ending
from engine.certified.contact.phase import Note, Phase, normal_force
from engine.certified.contact.series import ROLLING, SLIDING, Contact, Stretch
from engine.certified.scene import Scene
from engine.certified.surfaces import Surface

_PIECES = 4
"""Of a stretch, each with an enclosure of its own."""

_TERMS = 16
"""Of the Peano-Baker series."""


class Parting(NamedTuple):
    """A ball's derivative with respect to the start, at an event rather than at a time: of its
    time, of the way along the surface where it is, of the speeds off and along it, of the spin."""

    time: arb
    way: arb
    off: arb
    along: arb
    omega: arb


class SpreadPhase(Phase):
    """A contact phase of all balls of a box.

    `middle` is one of them, followed beside it: None from where it cannot be told that both go
    through the same. `parting` is that at the last event.
    """

    def __init__(
        self, scene: Scene, proof: Proof, note: Note, apart: arb, parting: Parting
    ) -> None:
        """`apart`: how far the starts are from the middle's, m."""
        super().__init__(scene, proof, note)
        self.parting, self._apart = parting, apart
        self.middle: Contact | None = None
        self._beside: Stretch | None = None
        self._known = Known(0, joint=False, touched=())

    def _stretch(self, surface: Surface, now: Contact, known: Known) -> Stretch:
        stretch = super()._stretch(surface, now, known)
        if self.middle is not None:
            same = replace(self.middle, mode=now.mode, slip_sign=now.slip_sign)
            if surface.curvature.is_zero():
                same = replace(same, nx=now.nx, ny=now.ny)
            if now.mode == ROLLING:
                radius = self.scene.radius
                same = replace(same, omega=same.u / radius)
                self.parting = self.parting._replace(omega=self.parting.along / radius)
            self._beside, self._known = Stretch(self.scene, surface, same), known
            ratio = self._beside.unit / stretch.unit * (1.0 - 1e-15)
            stretch.end = min(stretch.end, self._beside.end * ratio)
        return stretch

    def _moved(self, stretch: Stretch, ending: Ending) -> Contact:
        now = super()._moved(stretch, ending)
        if self.middle is None or self._beside is None:
            return now
        self.middle = self._middle_at(stretch, ending, self._beside)
        if self.middle is None:
            return now
        carried = _carried(stretch, ending.share, self.parting)
        self.parting = _at_event(stretch, ending, now, carried)
        cut = {
            name: getattr(now, name).intersection(getattr(self.middle, name) + rate * self._apart)
            for name, rate in _by_part(now, self.parting, stretch.kappa).items()
        }
        now = replace(now, **cut)
        return now

    def _middle_at(self, stretch: Stretch, ending: Ending, beside: Stretch) -> Contact | None:
        """The middle at the same end of the stretch."""
        if ending.cause is Cause.STEP:
            return beside.at(ending.share * arb(stretch.unit) / arb(beside.unit))
        try:
            own = first_ending(beside, self._known, Proof())
        except UndecidedError:
            return None
        return beside.at(own.share) if own[1:] == ending[1:] else None


def _by_part(now: Contact, parting: Parting, kappa: arb) -> dict[str, arb]:
    """The derivative of each part of a contact's state."""
    turn = kappa * parting.way
    return {
        "t": parting.time,
        "x": -now.ny * parting.way,
        "y": now.nx * parting.way,
        "nx": -now.ny * turn,
        "ny": now.nx * turn,
        "u": parting.along,
        "omega": parting.omega,
    }


class _Law:
    """The linear equation of the derivatives, where the normal and the speed are within balls."""

    def __init__(self, stretch: Stretch, nx: arb, ny: arb, u: arb) -> None:
        scene, mode = stretch.scene, stretch.start.mode
        self.gravity, self.drag, self.kappa = scene.gravity, scene.drag, stretch.kappa
        self.radius, self.rolls = scene.radius, mode == ROLLING
        self.share = ONE / 3 * 2 if self.rolls else ONE
        slides = mode == SLIDING
        self.grip = stretch.start.slip_sign * stretch.surface.pair.friction if slides else ZERO
        self.nx, self.ny, self.u = nx, ny, u

    def force(self, way: arb, u: arb) -> arb:
        """The change of the normal force by one of the way and one of the speed."""
        return -self.kappa * (self.gravity * self.nx * way + 2 * self.u * u)

    def drive(self, way: arb, u: arb) -> arb:
        """The change of what drives the ball along."""
        return -self.gravity * self.kappa * self.ny * way - self.drag * u

    def change(self, way: arb, u: arb) -> tuple[arb, arb, arb]:
        """How fast the derivatives of way, speed and spin (times the radius) change."""
        grip = self.grip * self.force(way, u)
        faster = self.share * self.drive(way, u) - grip
        return u, faster, faster if self.rolls else 2 * grip

    def norm(self) -> arb:
        """How much a change is larger than what it is of, in the largest norm, at most."""
        rows = zip(self.change(ONE, ZERO), self.change(ZERO, ONE), strict=True)
        return reduce(arb.max, (abs(a) + abs(b) for a, b in rows))


def _carried(stretch: Stretch, share: arb, parting: Parting) -> Parting:
    """The derivatives at the time `share` of a stretch, the same for all balls."""
    step = share / _PIECES * arb(stretch.unit)
    for i in range(_PIECES):
        piece = (share * i / _PIECES).union(share * (i + 1) / _PIECES)
        law = _Law(stretch, *(series.at(piece) for series in (stretch.nx, stretch.ny, stretch.u)))
        parting = _after(law, step, parting)
    return parting


def _after(law: _Law, step: arb, parting: Parting) -> Parting:
    """The derivatives `step` s later, while the law holds."""
    term = parting.way, parting.along, parting.omega * law.radius
    size = reduce(arb.max, map(abs, term))
    sums = list(term)
    for j in range(1, _TERMS):
        way, along, spin = law.change(term[0], term[1])
        term = way * step / j, along * step / j, spin * step / j
        sums = [a + b for a, b in zip(sums, term, strict=True)]
    growth = law.norm() * abs(step)
    rest = arb(0, (size * growth**_TERMS / factorial(_TERMS) * growth.exp()).abs_upper())
    way, along, spin = (part + rest for part in sums)
    return parting._replace(way=way, along=along, omega=spin / law.radius)


def _at_event(stretch: Stretch, ending: Ending, now: Contact, parting: Parting) -> Parting:
    """The derivatives where each ball comes to the end at its own time."""
    scene, surface, cause = stretch.scene, stretch.surface, ending.cause
    if cause is Cause.STEP:
        return parting
    law = _Law(stretch, now.nx, now.ny, now.u)
    force = normal_force(scene, surface, now.ny, now.u)
    faster = law.share * (scene.gravity * now.nx - scene.drag * now.u) - law.grip * force
    spins = faster / scene.radius if law.rolls else 2 * law.grip * force / scene.radius

    def off(way: arb, along: arb, omega: arb) -> arb:
        """The change of what is zero at the event."""
        if cause is Cause.LEAVES:
            return law.force(way, along)
        if cause is not Cause.CHANGES:
            return way  # the place on the surface is given
        if not law.rolls:
            return along - omega * scene.radius
        grip = 3 * surface.pair.friction
        return grip * law.force(way, along) - ending.slip_sign * law.drive(way, along)

    later = -off(parting.way, parting.along, parting.omega) / off(now.u, faster, spins)
    along, omega = parting.along + faster * later, parting.omega + spins * later
    moves = cause in (Cause.LEAVES, Cause.CHANGES)
    way = parting.way + now.u * later if moves else ZERO
    return Parting(parting.time + later, way, ZERO, along, omega)
