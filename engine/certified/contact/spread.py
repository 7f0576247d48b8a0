"""Follows all starts of an interval while the balls roll or slide, by derivative.py."""

from dataclasses import replace

from flint import arb

from plinko.engine.certified.balls import ZERO, Proof, UndecidedError
from plinko.engine.certified.contact.derivative import Parting, Variation, carried
from plinko.engine.certified.contact.endings import Cause, Ending, Known, first_ending
from plinko.engine.certified.contact.phase import Note, Phase
from plinko.engine.certified.contact.series import ROLLING, Contact, Stretch
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Surface


class SpreadPhase(Phase):
    """A contact phase of all balls of a box.

    `middle` is one of the balls, followed separately; None as soon as its events are not proven to
    be those of the box. `parting` is the derivative at the last event.
    """

    def __init__(
        self, scene: Scene, proof: Proof, note: Note, apart: arb, parting: Parting
    ) -> None:
        """`apart`: the differences of the starts from the middle's, a ball about 0, in m."""
        super().__init__(scene, proof, note)
        self.parting, self._apart = parting, apart
        self.middle: Contact | None = None
        self._of_middle: Stretch | None = None
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
            self._of_middle, self._known = Stretch(self.scene, surface, same, self.proof), known
            ratio = self._of_middle.unit / stretch.unit * (1.0 - 1e-15)
            stretch.end = min(stretch.end, self._of_middle.end * ratio)
        return stretch

    def _moved(self, stretch: Stretch, ending: Ending) -> Contact:
        now = super()._moved(stretch, ending)
        if self.middle is None or self._of_middle is None:
            return now
        self.middle = self._middle_at(stretch, ending, self._of_middle)
        if self.middle is None:
            return now
        parting = carried(stretch, ending.share, self.parting)
        self.parting = _at_event(stretch, ending, now, parting)
        cut = {
            name: getattr(now, name).intersection(getattr(self.middle, name) + rate * self._apart)
            for name, rate in _by_part(now, self.parting, stretch.law.curvature).items()
        }
        now = replace(now, **cut)
        return now

    def _middle_at(self, stretch: Stretch, ending: Ending, of_middle: Stretch) -> Contact | None:
        """The middle at the same ending; None unless it is proven to have that ending."""
        if ending.cause is Cause.STEP:
            return of_middle.at(ending.share * arb(stretch.unit) / arb(of_middle.unit))
        try:
            own = first_ending(of_middle, self._known, Proof())
        except UndecidedError:
            return None
        return of_middle.at(own.share) if own[1:] == ending[1:] else None


def _by_part(now: Contact, parting: Parting, kappa: arb) -> dict[str, arb]:
    """The derivative of each field of a contact's state."""
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


def _at_event(stretch: Stretch, ending: Ending, now: Contact, parting: Parting) -> Parting:
    """The derivatives at the ending, which each ball reaches at its own time.

    `parting` is at one time for all. A ball is `later` by the time in which the quantity that is
    zero at the event makes up for its change.
    """
    law, cause = stretch.law, ending.cause
    if cause is Cause.STEP:
        return parting
    variation = Variation(stretch, now.nx, now.ny, now.u)
    pull = variation.grip * law.normal_force(now.ny, now.u)
    faster = variation.share * law.drive(now.nx, now.u) - pull
    spins = faster / law.radius if variation.rolls else 2 * pull / law.radius

    def off(way: arb, along: arb, omega: arb) -> arb:
        """The change of the quantity that is zero at the event."""
        if cause is Cause.LEAVES:
            return variation.force(way, along)
        if cause is not Cause.CHANGES:
            return way  # the event is at a fixed position on the surface
        if not variation.rolls:
            return along - omega * law.radius
        grip = 3 * law.friction
        return grip * variation.force(way, along) - ending.slip_sign * variation.drive(way, along)

    later = -off(parting.way, parting.along, parting.omega) / off(now.u, faster, spins)
    along, omega = parting.along + faster * later, parting.omega + spins * later
    moves = cause in (Cause.LEAVES, Cause.CHANGES)
    way = parting.way + now.u * later if moves else ZERO
    return Parting(parting.time + later, way, ZERO, along, omega)
