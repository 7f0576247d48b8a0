"""Sustained contact, proven: a ball rolls or slides on a peg or wall until something ends it."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from flint import arb

from engine.certified.balls import ZERO, Proof, UndecidedError
from engine.certified.contact.endings import Cause, Ending, Known, first_ending
from engine.certified.contact.series import (
    FRICTIONLESS,
    ROLLING,
    SLIDING,
    Contact,
    Stretch,
)
from engine.certified.flight import State
from engine.certified.next_impact import LIFTED, PAST, ROLLED_OFF, Touch, Touched
from engine.certified.scene import Scene
from engine.certified.surfaces import Face, Surface
from engine.constants import KIND_CONTACT_CHANGE, KIND_CONTACT_END, KIND_PEG

_MAX_STRETCHES = 1000
"""Of one phase. A ball that drag brings to rest on level ground never stops for good."""

Note = Callable[[State, int, Surface], None]
"""Writes down an event: the state after it, its kind and the surface."""


class After(NamedTuple):
    """How a contact phase ended: what the ball touches then, what it hits, if it does."""

    state: State
    touched: Touched
    hit: Surface | None = None
    lands: bool = False
    rests: bool = False


def contact_index(surface: Surface) -> int:
    """How contact events name a surface: a peg by its index, wall w as -1 - w."""
    return surface.index if surface.kind == KIND_PEG else -1 - surface.index


def normal_force(scene: Scene, surface: Surface, ny: arb, u: arb) -> arb:
    """N per unit mass, m/s^2."""
    return -scene.gravity * ny - surface.curvature * u * u


class Phase:
    """One contact phase, stretch by stretch."""

    def __init__(self, scene: Scene, proof: Proof, note: Note) -> None:
        self.scene, self.proof, self.note = scene, proof, note

    def run(
        self, state: State, surface: Surface, sticks: bool, beside: tuple[Surface, ...]
    ) -> After:
        """Until the ball leaves, hits, lands or rests.

        `sticks` says that the impact before stopped the slip; `beside` are other surfaces that it
        touches and moves away from.
        """
        known = Known(1 if sticks else 0, joint=False, touched=beside)
        now = self._with_mode(settled(state, surface), surface, known)
        for _ in range(_MAX_STRETCHES):
            if now.nx.is_zero() and now.u.is_zero() and now.mode != SLIDING:
                return After(free(now), {}, rests=True)
            stretch = self._stretch(surface, now, known)
            ending = first_ending(stretch, known, self.proof)
            now = self._moved(stretch, ending)
            roots = 1 if now.mode == ROLLING else 0
            known = Known(roots, joint=False, touched=())
            if ending.cause is Cause.LEAVES:
                self.note(free(now), KIND_CONTACT_END, surface)
                return After(free(now), {surface: Touch(ROLLED_OFF, ZERO)})
            if ending.cause is Cause.HITS:
                return After(free(now), {surface: Touch(LIFTED, ZERO)}, hit=ending.surface)
            if ending.cause is Cause.LANDS:
                return After(free(now), {}, lands=True)
            if ending.cause is Cause.CHANGES:
                now, known = self._changed(now, surface, ending)
            elif ending.cause is Cause.PASSES and ending.surface is not None:
                before, surface = surface, ending.surface
                self.note(free(now), KIND_CONTACT_CHANGE, surface)
                force = normal_force(self.scene, surface, now.ny, now.u)
                what = f"whether the ball is pressed onto {surface.name}"
                if not self.proof.is_positive(force, what):
                    self.note(free(now), KIND_CONTACT_END, surface)
                    return After(free(now), _left(surface, before))
                now, known = self._passed(now, surface, known)
        raise UndecidedError(f"whether the ball stops on {surface.name}")

    def _stretch(self, surface: Surface, now: Contact, known: Known) -> Stretch:
        """The motion from here on; `known` for those that follow another ball beside this one."""
        return Stretch(self.scene, surface, now)

    def _moved(self, stretch: Stretch, ending: Ending) -> Contact:
        """The ball at the end of a stretch."""
        return stretch.at(ending.share)

    def _changed(self, now: Contact, surface: Surface, ending: Ending) -> tuple[Contact, Known]:
        """Rolling became sliding, against the force that is missing, or slipping has ended."""
        rolled = Known(2 if now.mode == ROLLING else 1, joint=False, touched=())
        u = now.u
        now = replace(now, omega=u / self.scene.radius)
        if rolled.slip_roots == 2:
            now = replace(now, mode=SLIDING, slip_sign=ending.slip_sign)
        else:
            now = self._with_mode(now, surface, rolled)
        self.note(free(now), KIND_CONTACT_CHANGE, surface)
        return now, rolled

    def _passed(self, now: Contact, surface: Surface, known: Known) -> tuple[Contact, Known]:
        """Onto a face or a wall's end: the normal stays, the curvature does not."""
        known = known._replace(joint=True)
        if isinstance(surface, Face):
            now = replace(now, nx=surface.nx, ny=surface.ny)
        return self._with_mode(now, surface, known), known

    def _with_mode(self, now: Contact, surface: Surface, known: Known) -> Contact:
        """Rolling, sliding or free: by the slip, and by Coulomb's law where it is zero."""
        friction = surface.pair.friction
        if friction.is_zero():
            return replace(now, mode=FRICTIONLESS, slip_sign=0)
        slip = now.u - now.omega * self.scene.radius
        if known.slip_roots == 0 and not slip.is_zero():
            positive = self.proof.is_positive(slip, "which way the ball slips")
            return replace(now, mode=SLIDING, slip_sign=1 if positive else -1)
        drive = self.scene.gravity * now.nx - self.scene.drag * now.u
        force = normal_force(self.scene, surface, now.ny, now.u)
        if self.proof.is_positive(3 * friction * force - abs(drive), "whether the ball rolls"):
            return replace(now, omega=now.u / self.scene.radius, mode=ROLLING, slip_sign=0)
        positive = self.proof.is_positive(drive, "which way the ball begins to slip")
        return replace(now, mode=SLIDING, slip_sign=1 if positive else -1)


def settled(state: State, surface: Surface) -> Contact:
    """A ball taken as staying on a surface."""
    nx, ny = surface.normal(state.x, state.y)
    u = state.vy * nx - state.vx * ny
    return Contact(state.t, state.x, state.y, nx, ny, u, state.omega, FRICTIONLESS, 0)


def free(now: Contact) -> State:
    """The same ball as in flight."""
    return State(now.t, now.x, now.y, -now.u * now.ny, now.u * now.nx, now.omega)


def _left(surface: Surface, before: Surface) -> Touched:
    """What a ball touches that a wall's end does not hold: that, and the face it is past."""
    touched: Touched = {surface: Touch(LIFTED, ZERO)}
    if isinstance(before, Face):
        touched[before] = Touch(PAST, ZERO)
    return touched
