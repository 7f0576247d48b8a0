"""All starts of an interval at once: one exact path in their middle, and how fast others part.

Boxes about a ball's state grow by more than the states in them part, since a box cannot turn with
them (the wrapping effect; Lohner, in Computer Arithmetic and Self-Validating Numerical Methods,
1990). By the mean value theorem the state of the start x + d is that of x, and d times the
derivative with respect to the start somewhere between: a point, and a line through it. Both are
enclosed at each event, the derivative over all states, and the box is cut with what they say.
"""

from operator import attrgetter
from typing import NamedTuple

from flint import arb

from engine.board.model import Board
from engine.certified.balls import ONE, ZERO, Proof
from engine.certified.flight import Flight, State, wide_basis
from engine.certified.impulse import Rebound
from engine.certified.next_impact import BOUNCED, Touch, Touched, next_impact
from engine.certified.scene import Scene, scene_of
from engine.certified.surfaces import Surface
from engine.certified.trace import Path, Tracer


class Rates(NamedTuple):
    """A state's derivative with respect to the start, at an event rather than at a time."""

    t: arb
    x: arb
    y: arb
    vx: arb
    vy: arb
    omega: arb


_parts = attrgetter(*Rates._fields)
AT_REST = Rates(ZERO, ONE, ZERO, ZERO, ZERO, ZERO)


class SpreadTracer(Tracer):
    """All balls that start within an interval, as long as one thing happens to them at a time.

    Where they stay on a surface, or touch two at once, the box alone goes on.
    """

    def __init__(self, scene: Scene, x: arb, proof: Proof) -> None:
        super().__init__(scene, x, proof)
        self._middle: Tracer | None = Tracer(scene, x.mid(), Proof())
        self._apart = x - x.mid()
        self._rates = AT_REST
        self._middle_touched: Touched = {}

    def _fly(self, touched: Touched) -> Touched:
        if self._middle is None or len(touched) > 1:
            self._middle = None
            return super()._fly(touched)
        flight = Flight(self.scene, self.state)
        hit = next_impact(self.scene, flight, touched, self.proof)
        same = Flight(self.scene, self._middle.state)
        of_middle = next_impact(self.scene, same, self._middle_touched, self._middle.proof)
        if hit is None or of_middle is None or len(hit.surfaces) > 1:
            self._middle = None
            return super()._fly(touched)
        self.state = flight.at(hit.time)
        self._middle.state = same.at(of_middle.time)
        normal = (ZERO, ONE)
        if hit.surfaces:
            normal = hit.surfaces[0].normal(self.state.x, self.state.y)
        self._rates = _through_flight(self._rates, flight, hit.time, self.state, normal)
        self._cut()
        if not hit.surfaces:
            self._land()
            return {}
        return self._hit(hit.surfaces[0], {hit.surfaces[0]: Touch(BOUNCED, ZERO)}, hit.approach)

    def _bounced(self, surface: Surface, after: Rebound, normal: tuple[arb, arb]) -> State:
        if self._middle is None:
            return super()._bounced(surface, after, normal)
        before = self.state
        self._rates = _through_bounce(
            self._rates, before, surface, after, normal, self.scene.radius
        )
        off, _ = self._middle.rebound(surface, None)
        self._middle_touched = {surface: Touch(BOUNCED, off)}
        self.state = super()._bounced(surface, after, normal)
        self._cut()
        return self.state

    def _stay(self, surface: Surface, touched: Touched, sticks: bool) -> Touched:
        self._middle = None
        return super()._stay(surface, touched, sticks)

    def _cut(self) -> None:
        """The box without what the mean value theorem rules out."""
        if self._middle is not None:
            rows = zip(_parts(self.state), _parts(self._middle.state), self._rates, strict=True)
            parts = [box.intersection(one + rate * self._apart) for box, one, rate in rows]
            self.state = State(*parts)


def trace_all(board: Board, x: arb, bits: int, proof: Proof) -> Path:
    """`trace` of an interval of starts; what is proven holds for each of them."""
    return SpreadTracer(scene_of(board, bits), x, proof).run()


def _through_flight(
    rates: Rates, flight: Flight, time: arb, end: State, normal: tuple[arb, arb]
) -> Rates:
    """At the end of a flight on a surface with this normal, where each ball comes at its time."""
    decay, phi, _ = wide_basis(flight, time)
    nx, ny = normal
    x, y = rates.x + rates.vx * phi, rates.y + rates.vy * phi
    later = -(nx * x + ny * y) / (nx * end.vx + ny * end.vy)
    return Rates(
        rates.t + later,
        x + end.vx * later,
        y + end.vy * later,
        rates.vx * decay + flight.ax * decay * later,
        rates.vy * decay + flight.ay * decay * later,
        rates.omega,
    )


def _through_bounce(
    rates: Rates, before: State, surface: Surface, after: Rebound, normal: tuple[arb, arb],
    radius: arb,
) -> Rates:  # fmt: skip
    """After an impact: the law of `impulse.bounce`, differentiated, whose normal turns too."""
    nx, ny = normal
    pair = surface.pair
    turn = surface.curvature * (rates.y * nx - rates.x * ny)  # dn = turn t, dt = -turn n
    approach, along = before.vx * nx + before.vy * ny, before.vy * nx - before.vx * ny
    d_approach = rates.vx * nx + rates.vy * ny + turn * along
    d_along = rates.vy * nx - rates.vx * ny - turn * approach
    push = ZERO
    if after.sticks:
        push = -(d_along - radius * rates.omega) / 3
    elif not pair.friction.is_zero():
        # The impulse is as large as the friction limit, and against the slip, whose sign is proven.
        slips_ahead = bool(along - before.omega * radius > 0)
        push = (1 if slips_ahead else -1) * pair.friction * (1 + pair.restitution) * d_approach
    d_omega = rates.omega - 2 * push / radius
    off = -pair.restitution * d_approach - turn * after.along
    slip = d_along + push + turn * after.off
    return Rates(rates.t, rates.x, rates.y, off * nx - slip * ny, off * ny + slip * nx, d_omega)
