"""Follows a contact phase by proof: a ball rolls or slides on a peg or wall until that ends."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from plinko.engine.certified.balls import ZERO, Proof, UndecidedError
from plinko.engine.certified.contact.damped import stretch_of
from plinko.engine.certified.contact.endings import Cause, Ending, Known, first_ending
from plinko.engine.certified.contact.series import (
    FRICTIONLESS,
    ROLLING,
    SLIDING,
    Contact,
    Stretch,
)
from plinko.engine.certified.flight import State
from plinko.engine.certified.next_impact import LIFTED, PAST, ROLLED_OFF, Touch, Touched
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Face, Surface
from plinko.engine.constants import KIND_CONTACT_CHANGE, KIND_CONTACT_END, KIND_PEG

_MAX_STRETCHES = 1000
"""Stretches of one phase. A ball that drag brings to rest on a level wall never quite stops."""

Note = Callable[[State, int, Surface], None]
"""Records an event: the state after it, its kind and the surface."""


class After(NamedTuple):
    """The end of a contact phase: the state, the surfaces touched, and the surface hit, if any."""

    state: State
    touched: Touched
    hit: Surface | None = None
    lands: bool = False
    rests: bool = False


def contact_index(surface: Surface, state: State) -> int:
    """The index of a surface in contact events: a peg's own, -1 - w for wall w."""
    index = surface.index_at(state.x, state.y)
    return index if surface.kind == KIND_PEG else -1 - index


class Phase:
    def __init__(self, scene: Scene, proof: Proof, note: Note) -> None:
        self.scene, self.proof, self.note = scene, proof, note

    def run(
        self, state: State, surface: Surface, sticks: bool, touched: tuple[Surface, ...]
    ) -> After:
        """Follow the ball until it leaves the surface, hits another one, lands or rests.

        `sticks`: whether the impact before stopped the slip. `touched`: other surfaces that the
        ball touches and moves away from.
        """
        known = Known(1 if sticks else 0, joint=False, touched=touched)
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
                force = self.scene.law_on(surface).normal_force(now.ny, now.u)
                what = f"whether the ball is pressed onto {surface.name}"
                if not self.proof.is_positive(force, what):
                    self.note(free(now), KIND_CONTACT_END, surface)
                    return After(free(now), _left(surface, before))
                now, known = self._passed(now, surface, known)
        raise UndecidedError(f"whether the ball stops on {surface.name}")

    def _stretch(self, surface: Surface, now: Contact, known: Known) -> Stretch:
        """The motion from here on. SpreadPhase also needs `known`, for its second ball."""
        return stretch_of(self.scene, surface, now, self.proof)

    def _moved(self, stretch: Stretch, ending: Ending) -> Contact:
        return stretch.at(ending.share)

    def _changed(self, now: Contact, surface: Surface, ending: Ending) -> tuple[Contact, Known]:
        """Rolling has become sliding in the direction `ending.slip_sign`, or slipping has ended."""
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
        """The ball has passed onto a face or a wall's end, which has another curvature.

        The normal is continuous; a face's own is the sharper enclosure.
        """
        known = known._replace(joint=True)
        if isinstance(surface, Face):
            now = replace(now, nx=surface.nx, ny=surface.ny)
        return self._with_mode(now, surface, known), known

    def _with_mode(self, now: Contact, surface: Surface, known: Known) -> Contact:
        """The mode of motion: sliding if there is slip, else as Coulomb's law decides."""
        law = self.scene.law_on(surface)
        if law.friction.is_zero():
            return replace(now, mode=FRICTIONLESS, slip_sign=0)
        slip = now.u - now.omega * law.radius
        if known.slip_roots == 0 and not slip.is_zero():
            positive = self.proof.is_positive(slip, "which way the ball slips")
            return replace(now, mode=SLIDING, slip_sign=1 if positive else -1)
        drive = law.drive(now.nx, now.u)
        force = law.normal_force(now.ny, now.u)
        if self.proof.is_positive(3 * law.friction * force - abs(drive), "whether the ball rolls"):
            return replace(now, omega=now.u / law.radius, mode=ROLLING, slip_sign=0)
        positive = self.proof.is_positive(drive, "which way the ball begins to slip")
        return replace(now, mode=SLIDING, slip_sign=1 if positive else -1)


def settled(state: State, surface: Surface) -> Contact:
    """The contact state of a ball that stays on a surface: its speed off it is dropped."""
    nx, ny = surface.normal(state.x, state.y)
    u = state.vy * nx - state.vx * ny
    return Contact(state.t, state.x, state.y, nx, ny, u, state.omega, FRICTIONLESS, 0)


def free(now: Contact) -> State:
    """The same ball as a state of flight."""
    return State(now.t, now.x, now.y, -now.u * now.ny, now.u * now.nx, now.omega)


def _left(surface: Surface, before: Surface) -> Touched:
    """What a ball touches when it flies off a wall's end: the end, and the face before it, whose
    end it has passed."""
    touched: Touched = {surface: Touch(LIFTED, ZERO)}
    if isinstance(before, Face):
        touched[before] = Touch(PAST, ZERO)
    return touched
