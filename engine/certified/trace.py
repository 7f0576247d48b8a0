"""A whole drop, proven: flights, impacts and contact phases at one precision."""

from dataclasses import dataclass, field

from flint import arb

from engine.board.model import Board
from engine.certified.balls import ZERO, Proof
from engine.certified.contact.phase import After, Phase, contact_index
from engine.certified.flight import Flight, State
from engine.certified.impulse import Rebound, bounce
from engine.certified.next_impact import BOUNCED, LIFTED, Touch, Touched, next_impact
from engine.certified.scene import Scene, scene_of
from engine.certified.surfaces import Surface
from engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_LANDING,
)
from engine.exact.free_flight import DYING_BOUNCE
from engine.exact.outcome import BALANCED, ESCAPED, EVENT_LIMIT, LANDED, RUNNING, WEDGED

MAX_EVENTS = 2000
"""A drop with more is left undecided: elastic balls bounce for ever."""


@dataclass(frozen=True, slots=True)
class Event:
    """The enclosed state right after something happened; kind and index as in a drop's record."""

    state: State
    kind: int
    index: int


@dataclass(slots=True)
class Path:
    """What became of a ball: how it ended (`engine.exact.outcome`), its bin, -1 if none."""

    outcome: int = RUNNING
    bin: int = -1
    events: list[Event] = field(default_factory=list)
    impacts: int = 0


def trace(board: Board, x: arb, bits: int, proof: Proof) -> Path:
    """Follow a ball from rest at x on the height of the start; `bits` is the precision that is set.

    x is in m, and may be wide: then what is proven holds for every start in it. Raises
    UndecidedError at the first comparison that the precision leaves open.
    """
    return Tracer(scene_of(board, bits), x, proof).run()


class Tracer:
    """One ball from its start to its end."""

    def __init__(self, scene: Scene, x: arb, proof: Proof) -> None:
        self.scene, self.proof = scene, proof
        self.state = State(ZERO, x, scene.start_y, ZERO, ZERO, ZERO)
        self.path = Path()

    def run(self) -> Path:
        """Until it lands, or comes to another end."""
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
        """A flight and what it ends with; what is touched when the next one starts."""
        flight = Flight(self.scene, self.state)
        hit = next_impact(self.scene, flight, touched, self.proof)
        if hit is None:
            self.path.outcome = ESCAPED
            return {}
        self.state = flight.at(hit.time)
        if not hit.surfaces:
            self._land()
            return {}
        return self._hit(
            hit.surfaces[0], dict.fromkeys(hit.surfaces, Touch(BOUNCED, ZERO)), hit.approach
        )

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

    def _hit(self, surface: Surface, touched: Touched, approach: arb | None = None) -> Touched:
        """Impacts, one after the other, on what the ball touches, until it flies or stays on one.

        `touched` has all that it touches, `surface` among them, which it approaches at `approach`
        if that is known.
        """
        while len(self.path.events) < MAX_EVENTS:
            off, sticks = self.rebound(surface, approach)
            approach = None
            touched[surface] = Touch(LIFTED if off.is_zero() else BOUNCED, off)
            if len(touched) > 1 and self._is_pinned(surface, touched):
                self.path.outcome = WEDGED
                return {}
            following = self._approached(surface, touched)
            if following is not None:
                surface = following
            elif not self.proof.is_positive(
                off - arb(DYING_BOUNCE), "whether a bounce dies"
            ) and self._is_pressed(surface):
                return self._stay(surface, touched, sticks)
            else:
                break
        return touched

    def rebound(self, surface: Surface, approach: arb | None) -> tuple[arb, bool]:
        """An impact: the speed off the surface after it, and whether friction stopped the slip."""
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
        self._note(surface.kind, surface.index)
        return after.off, after.sticks

    def _bounced(self, surface: Surface, after: Rebound, normal: tuple[arb, arb]) -> State:
        """The state after an impact on a surface with this normal where the ball is."""
        now, (nx, ny) = self.state, normal
        x, y = surface.at_contact(now.x, now.y, nx, ny)
        vx, vy = after.off * nx - after.along * ny, after.off * ny + after.along * nx
        return State(now.t, x, y, vx, vy, after.omega)

    def _is_pressed(self, surface: Surface) -> bool:
        """Whether gravity presses the ball onto a surface along which alone it moves: N > 0."""
        now = self.state
        nx, ny = surface.normal(now.x, now.y)
        along = now.vy * nx - now.vx * ny
        force = -self.scene.gravity * ny - surface.curvature * along * along
        return self.proof.is_positive(force, f"whether the ball is pressed onto {surface.name}")

    def _approached(self, left: Surface, touched: Touched) -> Surface | None:
        """Of the other surfaces that the ball touches, the first that it moves into."""
        now = self.state
        for other in sorted(touched, key=lambda s: s.rank):
            if other is left:
                continue
            nx, ny = other.normal(now.x, now.y)
            off = now.vx * nx + now.vy * ny
            if not self.proof.is_positive(off, f"whether the ball moves into {other.name}"):
                return other
            touched[other] = Touch(BOUNCED, off)
        return None

    def _stay(self, surface: Surface, touched: Touched, sticks: bool) -> Touched:
        """The ball rolls or slides, until it leaves, hits another surface or comes to its end."""
        nx, ny = surface.normal(self.state.x, self.state.y)
        now = self.state
        along = now.vy * nx - now.vx * ny
        self.state = State(now.t, now.x, now.y, -along * ny, along * nx, now.omega)
        self._note(KIND_CONTACT_BEGIN, contact_index(surface))
        beside = tuple(other for other in touched if other is not surface)
        after = self._follow(surface, sticks, beside)
        self.state = after.state
        if after.rests:
            self.path.outcome = BALANCED
        elif after.lands:
            self._land()
        elif after.hit is not None:
            if self._comes_to_rest(surface, after.hit):
                self.path.outcome = WEDGED
                return {}
            return self._hit(after.hit, {**after.touched, after.hit: Touch(BOUNCED, ZERO)})
        return after.touched

    def _follow(self, surface: Surface, sticks: bool, beside: tuple[Surface, ...]) -> After:
        phase = Phase(self.scene, self.proof, self.note_contact)
        return phase.run(self.state, surface, sticks, beside)

    def note_contact(self, state: State, kind: int, surface: Surface) -> None:
        """An event of a contact phase."""
        self.path.events.append(Event(state, kind, contact_index(surface)))

    def _comes_to_rest(self, surface: Surface, hit: Surface) -> bool:
        """Whether a ball that stayed on `surface` into `hit` has no speed left to go on with.

        Gravity along the tangent of each must push into the other.
        """
        now = self.state
        nx, ny = hit.normal(now.x, now.y)
        speed = -(now.vx * nx + now.vy * ny)
        what = f"whether the ball stops at {hit.name}"
        if self.proof.is_positive(speed - arb(DYING_BOUNCE), what):
            return False
        return self._is_wedged(surface, hit)

    def _is_pinned(self, hit: Surface, touched: Touched) -> bool:
        """Whether a ball that hit `hit` has no speed left and is wedged against another."""
        now = self.state
        square = now.vx * now.vx + now.vy * now.vy
        if self.proof.is_positive(square - arb(DYING_BOUNCE) ** 2, "whether the ball stops"):
            return False
        return any(self._is_wedged(other, hit) for other in touched if other is not hit)

    def _is_wedged(self, a: Surface, b: Surface) -> bool:
        """Whether gravity presses a ball that touches both against both."""
        now = self.state
        ax, ay = a.normal(now.x, now.y)
        bx, by = b.normal(now.x, now.y)
        cross = ax * by - ay * bx
        what = f"whether the ball is wedged between {a.name} and {b.name}"
        is_positive = self.proof.is_positive
        return is_positive(-ax * cross, what) and is_positive(bx * cross, what)
