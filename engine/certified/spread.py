"""Follows all starts of an interval at once: the path of their middle, and a derivative.

A box around the states of many balls grows faster than the states spread, because a box cannot
turn with them (the wrapping effect; Lohner, in Computer Arithmetic and Self-Validating Numerical
Methods, 1990). By the mean value theorem the state of the start x + d is that of x plus d times the
derivative with respect to the start at some point between. At each event, both are enclosed, the
derivative over all states, and the box is intersected with their sum.
"""

from operator import attrgetter
from typing import NamedTuple

from flint import arb

from plinko.engine.board.model import Board
from plinko.engine.certified.balls import ONE, ZERO, Proof
from plinko.engine.certified.contact.derivative import Parting
from plinko.engine.certified.contact.phase import After, free, settled
from plinko.engine.certified.contact.spread import SpreadPhase
from plinko.engine.certified.flight import Flight, State, wide_basis
from plinko.engine.certified.impulse import Rebound
from plinko.engine.certified.next_impact import BOUNCED, Hit, Touch, Touched, next_impact
from plinko.engine.certified.scene import Scene, scene_of
from plinko.engine.certified.surfaces import Surface
from plinko.engine.certified.trace import Path, Tracer

Vector = tuple[arb, arb]

_parts = attrgetter("t", "x", "y", "vx", "vy", "omega")

STARTS: Vector = ZERO, -ONE
"""The normal of the line on which balls start, and of the line on which they land."""


Change = tuple[arb, arb, arb, arb]
"""Changes of an event's time, of the way along the surface, and of the speeds off and along it."""


class Frame(NamedTuple):
    """The normal n of a surface where a ball touches it, and the ball's speeds v.n and v.t.

    A way p further along the surface, n has turned by curvature p towards t = (-n_y, n_x).
    """

    normal: Vector
    curvature: arb
    off: arb
    along: arb

    @classmethod
    def of(cls, normal: Vector, curvature: arb, state: State) -> "Frame":
        """The frame of a ball with this state."""
        (nx, ny), vx, vy = normal, state.vx, state.vy
        return cls(normal, curvature, vx * nx + vy * ny, vy * nx - vx * ny)

    @property
    def tangent(self) -> Vector:
        return -self.normal[1], self.normal[0]

    def parts(self, x: arb, y: arb) -> Vector:
        """The components of a vector along the normal and along the tangent."""
        nx, ny = self.normal
        return nx * x + ny * y, nx * y - ny * x

    def turned(self, way: arb, off: arb, along: arb) -> Vector:
        """The change of the velocity along n and t, from the changes of the way and both speeds."""
        turn = self.curvature * way
        return off - turn * self.along, along + turn * self.off

    def of_speeds(self, way: arb, off: arb, along: arb) -> Vector:
        """The changes of both speeds, from those of the way and of the velocity along n and t."""
        turn = self.curvature * way
        return off + turn * self.along, along - turn * self.off


class SpreadTracer(Tracer):
    """Follows all balls that start within an interval.

    From the first event that the derivative does not cover (two surfaces at once, a lift without a
    speed) only the box goes on, and `_middle` is None.
    """

    def __init__(self, scene: Scene, x: arb, proof: Proof) -> None:
        super().__init__(scene, x, proof)
        self._middle: Tracer | None = Tracer(scene, x.mid(), Proof())
        self._apart = x - x.mid()
        self._parting = Parting(ZERO, ONE, ZERO, ZERO, ZERO)
        self._frame = Frame(STARTS, ZERO, ZERO, ZERO)
        self._on: Surface | None = None
        self._middle_touched: Touched = {}
        self._approach: arb | None = None

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
        self._middle.state, self._approach = same.at(of_middle.time), of_middle.approach
        self._part(flight, hit)
        self._cut()
        if not hit.surfaces:
            self._land()
            return {}
        return self._hit(hit.surfaces[0], hit.approach)

    def _part(self, flight: Flight, hit: Hit) -> None:
        """Carry the derivatives through a flight, as the sum of the images of each of them.

        The images are computed first and then multiplied by the derivatives, which are wide. So
        terms that nearly cancel, as in a ball that bounces to rest, cancel between sharp numbers.
        """
        surface = hit.surfaces[0] if hit.surfaces else None
        normal = surface.normal(self.state.x, self.state.y) if surface else STARTS
        bend = surface.curvature if surface else ZERO
        after = Frame.of(normal, bend, self.state)
        if hit.approach is not None:
            after = after._replace(off=hit.approach)
        moved = _Moved(flight, hit.time, self._frame, after, again=surface is self._on)
        now = self._parting
        columns = zip(*moved.columns(), strict=True)
        time, way, off, along = (
            now.way * by_way + now.off * by_off + now.along * by_along
            for by_way, by_off, by_along in columns
        )
        self._parting = Parting(now.time + time, way, off, along, now.omega)
        self._frame, self._on = after, surface

    def _bounced(self, surface: Surface, after: Rebound, normal: Vector) -> State:
        if self._middle is None or surface is not self._on:
            self._middle = None
            return super()._bounced(surface, after, normal)
        radius = self.scene.radius
        self._parting = _through_bounce(
            self._parting, self._frame, self.state, surface, after, radius
        )
        self._frame = self._frame._replace(off=after.off, along=after.along)
        off, _ = self._middle.rebound(surface, self._approach)
        self._middle_touched = {surface: Touch(BOUNCED, off)}
        self.state = super()._bounced(surface, after, normal)
        self._cut()
        return self.state

    def _meet(self, a: Surface, b: Surface) -> Touched:
        self._middle = None
        return super()._meet(a, b)

    def _lift(self, touched: Touched) -> Touched:
        self._middle = None
        return super()._lift(touched)

    def _follow(self, surface: Surface, sticks: bool, touched: tuple[Surface, ...]) -> After:
        if self._middle is None:
            return super()._follow(surface, sticks, touched)
        phase = SpreadPhase(self.scene, self.proof, self.note_contact, self._apart, self._parting)
        phase.middle = settled(self._middle.state, surface)
        after = phase.run(self.state, surface, sticks, touched)
        if phase.middle is None:
            self._middle = None
        else:
            self._middle.state, self._middle_touched = free(phase.middle), after.touched
            self._parting = phase.parting
            self._on = next(iter(after.touched), None)
            if self._on is not None:
                normal = self._on.normal(after.state.x, after.state.y)
                frame = Frame.of(normal, self._on.curvature, after.state)
                self._frame = frame._replace(off=ZERO)
        return after

    def _cut(self) -> None:
        """Intersect the box with the enclosure that the mean value theorem gives."""
        if self._middle is None:
            return
        (nx, ny), part = self._frame.normal, self._parting
        off, along = self._frame.turned(part.way, part.off, part.along)
        vx, vy = off * nx - along * ny, off * ny + along * nx
        rates = part.time, -ny * part.way, nx * part.way, vx, vy, part.omega
        rows = zip(_parts(self.state), _parts(self._middle.state), rates, strict=True)
        parts = [box.intersection(one + rate * self._apart) for box, one, rate in rows]
        self.state = State(*parts)


def trace_all(board: Board, x: arb, bits: int, proof: Proof) -> Path:
    """`trace` of an interval of starts; the result is proven for each of them."""
    return SpreadTracer(scene_of(board, bits), x, proof).run()


class _Moved:
    """Maps changes at a flight's start to changes at its end, which each ball reaches at its own
    time."""

    def __init__(
        self, flight: Flight, time: arb, before: Frame, after: Frame, *, again: bool
    ) -> None:
        """`again`: the flight ends on the surface on which it started.

        The gap to that surface then changes only by its curvature, which is sharper than the
        difference of two normals.
        """
        self.before, self.after = before, after
        self.decay, self.phi, psi = wide_basis(flight, time)
        self.pull = after.parts(flight.ax * self.decay, flight.ay * self.decay)
        self.bend = None
        if again:
            start, (tx, ty) = flight.start, before.tangent
            way = start.vx * time + flight.ax * psi, start.vy * time + flight.ay * psi
            self.bend = before.curvature * (way[0] * tx + way[1] * ty)

    def columns(self) -> tuple[Change, Change, Change]:
        """The images of a unit of way along the first surface, of speed off it and of speed along
        it."""
        ahead, off = self.before.tangent, self.before.normal
        by_off, by_along = self.before.turned(ONE, ZERO, ZERO)
        (ox, oy), (ax, ay) = off, ahead
        turned = by_off * ox + by_along * ax, by_off * oy + by_along * ay
        gap, way = self.after.parts(*ahead)
        if self.bend is not None:
            gap = self.bend
        return (
            self._image(gap, way, turned),
            self._image(ZERO, ZERO, off),
            self._image(ZERO, ZERO, ahead),
        )

    def _image(self, gap: arb, way: arb, velocity: Vector) -> Change:
        """The image of a change of position, given off and along the last surface, and velocity."""
        after = self.after
        faster_off, faster_along = after.parts(*velocity)
        later = -(gap + faster_off * self.phi) / after.off
        way = way + faster_along * self.phi + after.along * later
        off = faster_off * self.decay + self.pull[0] * later
        along = faster_along * self.decay + self.pull[1] * later
        return later, way, *after.of_speeds(way, off, along)


def _through_bounce(
    parting: Parting, frame: Frame, before: State, surface: Surface, after: Rebound, radius: arb
) -> Parting:
    """The derivatives after an impact: the law of `impulse.bounce`, differentiated."""
    pair = surface.pair
    push = ZERO
    if after.sticks:
        push = -(parting.along - radius * parting.omega) / 3
    elif not pair.friction.is_zero():
        # The impulse is at the friction limit, and against the slip, whose sign is proven.
        slips_ahead = bool(frame.along - before.omega * radius > 0)
        push = (1 if slips_ahead else -1) * pair.friction * (1 + pair.restitution) * parting.off
    return parting._replace(
        off=-pair.restitution * parting.off,
        along=parting.along + push,
        omega=parting.omega - 2 * push / radius,
    )
