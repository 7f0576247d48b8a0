"""Follows a whole drop by proof: flights, impacts and contact phases at one precision."""

from dataclasses import dataclass, field, replace

from flint import arb

from plinko.engine.board.model import Board
from plinko.engine.certified.balls import ZERO, Proof, UndecidedError
from plinko.engine.certified.contact.phase import After, Phase, contact_index
from plinko.engine.certified.flight import Flight, State
from plinko.engine.certified.impulse import Rebound, bounce
from plinko.engine.certified.next_impact import (
    BOUNCED,
    LIFTED,
    Touch,
    Touched,
    next_impact,
    slid_along,
)
from plinko.engine.certified.scene import Scene, scene_of
from plinko.engine.certified.surfaces import Face, Surface
from plinko.engine.constants import KIND_CONTACT_BEGIN, KIND_CONTACT_END, KIND_LANDING
from plinko.engine.exact.free_flight import DYING_BOUNCE
from plinko.engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    IMPULSE_LIMIT,
    LANDED,
    RUNNING,
    WEDGED,
)
from plinko.engine.exact.two_contacts import MOST_IMPULSES, STOPPED
from plinko.engine.physics.surface import ROUNDING
from plinko.engine.physics.two_contacts import FALLS, GOES_ON_A, GOES_ON_B, JAMS, RESTS, SPINS

DEAD = arb(DYING_BOUNCE)

MAX_EVENTS = 2000
"""Events of one drop. Elastic balls bounce for ever; a drop that reaches this is undecided."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event and the enclosed state right after it; kind and index as in a drop's record."""

    state: State
    kind: int
    index: int


@dataclass(slots=True)
class Path:
    """A ball's events, its outcome (a code of `plinko.engine.exact.outcome`) and its bin, -1 if
    none.
    """

    outcome: int = RUNNING
    bin: int = -1
    events: list[Event] = field(default_factory=list)
    impacts: int = 0


def trace(board: Board, x: arb, bits: int, proof: Proof) -> Path:
    """Follow a ball from rest at x, in m, at the board's start height.

    `bits` is the current precision. x may be a wide ball: the path then holds for every start in
    it. Raises UndecidedError at the first comparison that the precision leaves open.
    """
    return Tracer(scene_of(board, bits), x, proof).run()


class Tracer:
    """Follows one ball from its start to its end."""

    def __init__(self, scene: Scene, x: arb, proof: Proof) -> None:
        self.scene, self.proof = scene, proof
        self.state = State(ZERO, x, scene.start_y, ZERO, ZERO, ZERO)
        self.path = Path()

    def run(self) -> Path:
        touched: Touched = {}
        while self.path.outcome == RUNNING:
            if len(self.path.events) >= MAX_EVENTS:
                self.path.outcome = EVENT_LIMIT
                break
            touched = self._fly(touched)
        return self.path

    def _note(self, kind: int, index: int) -> None:
        self.path.events.append(Event(self.state, kind, index))

    def _fly(self, touched: Touched) -> Touched:
        """One flight and the impact or contact after it.

        Returns the surfaces that the ball touches when the next flight starts.
        """
        flight = Flight(self.scene, self.state)
        hit = next_impact(self.scene, flight, touched, self.proof)
        if hit is None:
            self.path.outcome = ESCAPED
            return {}
        self.state = flight.at(hit.time)
        if not hit.surfaces:
            self._land()
            return {}
        if len(hit.surfaces) > 2:
            raise UndecidedError("what an impact on three surfaces at once does")
        if len(hit.surfaces) == 2:
            return self._meet(*hit.surfaces)
        along = self._slid_along(flight, touched)
        if along is not None:
            return self._meet(along, hit.surfaces[0])
        return self._hit(hit.surfaces[0], hit.approach)

    def _slid_along(self, flight: Flight, touched: Touched) -> Face | None:
        """A face that the ball has touched throughout its flight, and touches now."""
        for face in slid_along(flight, touched):
            place = face.along(self.state.x, self.state.y)
            what = f"whether the ball is on {face.name}"
            if self.proof.is_positive(place, what) and self.proof.is_positive(
                face.length - place, what
            ):
                return face
        return None

    def _land(self) -> None:
        edges = self.scene.edges
        bin_ = 0
        for edge in edges[1:-1]:
            # An edge belongs to the bin on its right.
            if self.proof.is_positive(edge - self.state.x, "which side of a bin's edge is landed"):
                break
            bin_ += 1
        self.path.outcome, self.path.bin = LANDED, bin_
        self._note(KIND_LANDING, bin_)

    def _hit(self, surface: Surface, approach: arb | None) -> Touched:
        """An impact at the speed `approach`, and the contact phase if the bounce dies there."""
        off, sticks = self.rebound(surface, approach)
        if self.proof.is_positive(off - DEAD, "whether a bounce dies"):
            return {surface: Touch(BOUNCED, off)}
        self._align(surface)
        if self._is_pressed(surface):
            return self._stay(surface, (), sticks)
        return self._lift({surface: Touch(LIFTED, ZERO)})

    def rebound(self, surface: Surface, approach: arb | None) -> tuple[arb, bool]:
        """Apply an impact. Returns the speed off the surface, and whether friction ended the slip.

        `approach` is v.n, if the caller knows it more sharply than the velocity gives it.
        """
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        if approach is None:
            approach = now.vx * nx + now.vy * ny
        along = now.vy * nx - now.vx * ny
        self.proof.require(bool(approach < 0), f"whether the ball approaches {surface.name}")
        after: Rebound = bounce(
            approach, along, now.omega, surface.pair, self.scene.radius, self.proof
        )
        self.state = self._bounced(surface, after, (nx, ny))
        self.path.impacts += 1
        self._note(surface.kind, surface.index_at(self.state.x, self.state.y))
        return after.off, after.sticks

    def _bounced(self, surface: Surface, after: Rebound, normal: tuple[arb, arb]) -> State:
        """The state after an impact on a surface that has this normal at the ball's position.

        The position is projected onto the surface, which makes its enclosure sharper.
        """
        now, (nx, ny) = self.state, normal
        x, y = surface.at_contact(now.x, now.y, nx, ny)
        vx, vy = after.off * nx - after.along * ny, after.off * ny + after.along * nx
        return State(now.t, x, y, vx, vy, after.omega)

    def _is_pressed(self, surface: Surface) -> bool:
        """Whether the normal force N on a ball that moves only along the surface is positive."""
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        along = now.vy * nx - now.vx * ny
        force = -self.scene.gravity * ny - surface.curvature * along * along
        return self.proof.is_positive(force, f"whether the ball is pressed onto {surface.name}")

    def _align(self, surface: Surface) -> None:
        """Set the ball's speed off a surface to zero."""
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        along = now.vy * nx - now.vx * ny
        self.state = replace(now, vx=-along * ny, vy=along * nx)

    def _lift(self, touched: Touched) -> Touched:
        """The ball flies off surfaces with no speed off them; a hook for SpreadTracer."""
        return touched

    def _stay(
        self, surface: Surface, touched: tuple[Surface, ...], sticks: bool, *, begins: bool = True
    ) -> Touched:
        """A contact phase, until the ball leaves the surface, hits another one, lands or rests.

        `touched`: other surfaces that it touches and moves off. `begins`: whether the contact
        begins here, which is an event.
        """
        if begins:
            self.note_contact(self.state, KIND_CONTACT_BEGIN, surface)
        after = self._follow(surface, sticks, touched)
        self.state = after.state
        if after.rests:
            self.path.outcome = BALANCED
        elif after.lands:
            self._land()
        elif after.hit is not None:
            return self._meet(next(iter(after.touched)), after.hit)
        return after.touched

    def _follow(self, surface: Surface, sticks: bool, touched: tuple[Surface, ...]) -> After:
        phase = Phase(self.scene, self.proof, self.note_contact)
        return phase.run(self.state, surface, sticks, touched)

    def note_contact(self, state: State, kind: int, surface: Surface) -> None:
        self.path.events.append(Event(state, kind, contact_index(surface, state)))

    # Two surfaces at once: the laws of `plinko.engine.exact.two_contacts`.

    def _meet(self, a: Surface, b: Surface) -> Touched:
        """A ball that touches a meets b: impulses in turn, until it approaches neither.

        After MOST_IMPULSES the drop ends without a result, as in the exact solver.
        """
        last, sticks, impulses = b, False, 0
        while approached := self._approached(a, b):
            if impulses == MOST_IMPULSES:
                self.path.outcome = IMPULSE_LIMIT
                return {}
            impulses += 1
            last = approached[0]
            _, sticks = self.rebound(last, None)
        if self._is_slow():
            self.state = replace(self.state, vx=ZERO, vy=ZERO)
            return self._rest(a, b)
        left = [s for s in (a, b) if self._leaves(s)]
        if len(left) == 2:
            return {s: Touch(BOUNCED, self._off(s)) for s in (last, b if last is a else a)}
        if not left:
            for stays, other in ((a, b), (b, a)):
                if self._slides_off(stays, other):
                    return self._go_on(stays, other, sticks=False)
            self.state = replace(self.state, vx=ZERO, vy=ZERO)
            return self._rest(a, b)
        stays = b if left[0] is a else a
        return self._go_on(stays, left[0], sticks=sticks and last is stays)

    def _off(self, surface: Surface) -> arb:
        """Speed off a surface, m/s; negative towards it."""
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        return now.vx * nx + now.vy * ny

    def _approached(self, *surfaces: Surface) -> list[Surface]:
        """The surfaces that the ball moves into faster than DYING_BOUNCE, in order of rank."""
        return [
            surface
            for surface in sorted(surfaces, key=lambda s: s.rank)
            if not self.proof.is_positive(
                self._off(surface) + DEAD, f"whether the ball moves into {surface.name}"
            )
        ]

    def _leaves(self, surface: Surface) -> bool:
        what = f"whether the ball leaves {surface.name}"
        return self.proof.is_positive(self._off(surface) - DEAD, what)

    def _slides_off(self, surface: Surface, other: Surface) -> bool:
        """Whether the ball, moving along one surface, does not move into the other."""
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        other_x, other_y = other.normal(now.x, now.y)
        into = -(now.vy * nx - now.vx * ny) * (other_y * nx - other_x * ny)
        return not self.proof.is_positive(into, f"whether the ball slides off {other.name}")

    def _is_slow(self) -> bool:
        """Whether the ball is too slow to leave the notch between two surfaces.

        As in `plinko.engine.exact.two_contacts`: slower than STOPPED, or than a fall through the
        rounding of its position would make it.
        """
        now = self.state
        height = arb(ROUNDING) * (abs(now.x) + abs(now.y))
        enough = arb.max(arb(STOPPED) ** 2, 2 * self.scene.gravity * height)
        square = now.vx * now.vx + now.vy * now.vy
        return not self.proof.is_positive(square - enough, "whether the ball stops")

    def _go_on(self, surface: Surface, other: Surface, *, sticks: bool) -> Touched:
        """The ball continues along one surface and moves off the other."""
        off = self._off(other)
        self._align(surface)
        if self._is_pressed(surface):
            return self._stay(surface, (other,), sticks)
        return self._lift({surface: Touch(LIFTED, ZERO), other: Touch(BOUNCED, off)})

    def _rest(self, a: Surface, b: Surface) -> Touched:
        """A ball at rest in the notch: friction stops its spin, then it rests, falls or leaves."""
        rest, brake = self._rest_in_notch(a, b)
        spun = rest == SPINS
        if spun:
            self.note_contact(self.state, KIND_CONTACT_BEGIN, a)
            self.note_contact(self.state, KIND_CONTACT_BEGIN, b)
            spins_for = abs(self.state.omega) * self.scene.radius / (2 * brake)
            self.state = replace(self.state, t=self.state.t + spins_for)
        if spun or rest == JAMS:
            self.state = replace(self.state, omega=ZERO)
            rest, _ = self._rest_in_notch(a, b)
        if rest == RESTS:
            self.path.outcome = WEDGED
            return {}
        if rest == FALLS:
            return self._lift({b: Touch(LIFTED, ZERO), a: Touch(LIFTED, ZERO)})
        stays, opened = (a, b) if rest == GOES_ON_A else (b, a)
        if spun:
            self.note_contact(self.state, KIND_CONTACT_END, opened)
        return self._stay(stays, (opened,), sticks=False, begins=not spun)

    def _rest_in_notch(self, a: Surface, b: Surface) -> tuple[int, arb]:
        """`plinko.engine.physics.two_contacts.rest_in_notch` with every comparison proven.

        Returns a code of that module, and while the ball spins the friction that brakes it, m/s^2.
        """
        is_positive, gravity, omega = self.proof.is_positive, self.scene.gravity, self.state.omega
        (ax, ay), (bx, by) = (s.normal(self.state.x, self.state.y) for s in (a, b))
        what = f"what a ball at rest between {a.name} and {b.name} does"
        pressed_on_a = is_positive(-gravity * ay, what)
        pressed_on_b = is_positive(-gravity * by, what)
        if not (pressed_on_a or pressed_on_b):
            return FALLS, ZERO
        cross = ax * by - ay * bx  # t_a . n_b; t_b . n_a is -cross

        def opens(pressed: bool, pull: arb, nx: arb, ny: arb, away: arb) -> bool:
            along = gravity * nx - pull * gravity * ny
            return pressed and not is_positive(-along * away, what)

        if omega.is_zero() or (a.pair.friction.is_zero() and b.pair.friction.is_zero()):
            if opens(pressed_on_a, ZERO, ax, ay, cross):
                return GOES_ON_A, ZERO
            return (GOES_ON_B if opens(pressed_on_b, ZERO, bx, by, -cross) else RESTS), ZERO
        sense = arb(1 if is_positive(omega, "which way the ball spins") else -1)
        pull_a, pull_b = sense * a.pair.friction, sense * b.pair.friction
        rax, ray = ax - pull_a * ay, ay + pull_a * ax
        rbx, rby = bx - pull_b * by, by + pull_b * bx
        turn = rax * rby - ray * rbx
        self.proof.require(bool(turn != 0), what)
        force_a, force_b = gravity * rbx / turn, -gravity * rax / turn
        holds_a, holds_b = is_positive(force_a, what), is_positive(force_b, what)
        if holds_a and holds_b:
            return SPINS, a.pair.friction * force_a + b.pair.friction * force_b
        stays_on_a = opens(pressed_on_a, pull_a, ax, ay, cross)
        stays_on_b = opens(pressed_on_b, pull_b, bx, by, -cross)
        if stays_on_a and (not holds_b or not stays_on_b):
            return GOES_ON_A, ZERO
        return (GOES_ON_B if stays_on_b else JAMS), ZERO
