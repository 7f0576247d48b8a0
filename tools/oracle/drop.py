"""A whole drop from textbook laws: flights, impacts and contacts, to any number of digits."""

import math
import random
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import Final

from plinko.engine.board.model import Board
from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_LANDING,
    KIND_PEG,
)
from tools.oracle.contact import (
    End,
    Riding,
    Stretch,
    following,
    pressing,
    ride,
    settle,
    with_slip,
)
from tools.oracle.flight import Flight, Point, first_hit
from tools.oracle.laws import SPIN_TERM, impact
from tools.oracle.roots import OracleError
from tools.oracle.scene import Body, Circle, Face, Real, Scene

CUT: Final = 1e-8  # m/s: a slower rebound is taken as the beginning of a contact
NUDGE: Final = 1e-25  # m: how far the second run of an amplification starts from the first
SHAKES: Final = (
    4  # runs with other signs of the changes at impacts: in a single run they may cancel
)
NOTCH: Final = 1e-7
"""Sine of the least angle between two surfaces that make a notch; a flatter one is a bend."""
DEEPEST: Final = 1e-12  # m: a deeper ball is in a body
MAX_SECONDS: Final = 1000  # simulated; longer than any drop that ends


@dataclass(frozen=True)
class Event:
    """The state right after something happened; `kind` and `index` as in engine.constants.

    approach: speed in m/s towards the body right before an impact, otherwise 0.
    """

    t: Real
    x: Real
    y: Real
    vx: Real
    vy: Real
    omega: Real
    kind: int
    index: int
    approach: Real = 0


@dataclass(frozen=True)
class Spinning:
    """A ball that spins down in a notch while its centre rests, `span` seconds from `start` on."""

    start: Point
    span: Real

    def point(self, share: Real) -> Point:
        """The state at `share` (0 to 1) of the span; the spin falls evenly to zero."""
        s, tau = self.start, share * self.span
        theta = s.theta + s.omega * tau * (1 - share / 2)
        return s._replace(t=s.t + tau, theta=theta, omega=s.omega * (1 - share))


@dataclass
class OracleDrop:
    """The result of one drop. Numbers are mpf; `bin` is None if the ball never lands.

    The growth of errors is measured by further runs, which are played on first use: one for
    `amplifications`, SHAKES for `growths`.
    """

    bin: int | None
    duration: Real
    x_end: Real
    events: list[Event]
    reason: str | None
    _pieces: list["Flight | Stretch | Spinning"] = field(default_factory=list)
    _again: "Callable[[Real, int], OracleDrop] | None" = (
        None  # plays again, with a shake and its pattern
    )

    @cached_property
    def amplifications(self) -> list[float]:
        """Metres that the position at each event moves per metre that the start moves.

        Measured by a second run, started NUDGE metres away; infinite after their events differ.
        """
        return _spread(self, self._beside)

    @cached_property
    def amplification(self) -> float:
        """The last of `amplifications`, of x_end; infinite if the runs have different events."""
        same = len(self.events) == len(self._beside.events) and bool(self.amplifications)
        return self.amplifications[-1] if same else math.inf

    @cached_property
    def growths(self) -> list[float]:
        """Distance at each event to the farthest of SHAKES further runs, per NUDGE.

        These runs start NUDGE metres away, and their velocity changes by the factor 1 +- NUDGE at
        every impact. They show how rounding grows on the way, even if a contact phase has made the
        ball forget its start.
        """
        spreads = [_spread(self, self.nudged(NUDGE, pattern)) for pattern in range(SHAKES)]
        return [max(at_event) for at_event in zip(*spreads, strict=True)]

    @cached_property
    def _beside(self) -> "OracleDrop":
        return self.nudged(0.0, 0)

    def nudged(self, shake: float, pattern: int) -> "OracleDrop":
        """The drop again, nudged: started NUDGE m away, and shaken at impacts; see `growths`."""
        assert self._again is not None, "a neighbour's own neighbours are never asked for"
        return self._again(shake, pattern)

    def state_at(self, t: float) -> Point:
        """The whole state `t` seconds after the start, 0 <= t <= duration."""
        if not 0 <= t <= self.duration:
            raise ValueError(f"t = {t} is outside of the drop")
        piece = self._pieces[bisect_right(self._pieces, t, key=lambda p: p.start.t) - 1]
        if isinstance(piece, Flight):
            return piece.at(t - piece.start.t)
        return piece.point((t - piece.start.t) / piece.span)

    def position_at(self, t: float) -> tuple[Real, Real]:
        """Centre of the ball `t` seconds after the start, in metres."""
        state = self.state_at(t)
        return state.x, state.y


class Run:
    """Plays one ball from its start to its end."""

    def __init__(
        self,
        scene: Scene,
        x_start: Real,
        max_events: int,
        cut: Real,
        shake: Real = 0,
        pattern: int = 0,
    ) -> None:
        self.scene, self.cut, self.max_events = scene, cut, max_events
        self.shake, self.signs = shake, random.Random(len(scene.circles) + pattern)
        zero = scene.ctx.zero
        self.now = Point(zero, x_start, scene.start_y, zero, zero, zero, zero)
        self.events: list[Event] = []
        self.pieces: list[Flight | Stretch | Spinning] = []
        self.end: str | None = None  # the reason why the run is over
        self.done_with: list[Face] = []

    def run(self) -> OracleDrop:
        """Play the ball until it lands, rests, or has too many events."""
        while self.end is None:
            self._fly_or_hit()
            if len(self.events) >= self.max_events:
                self.end = "too many events"
        landed = self.end == "landed"
        slot = self.scene.bin_of(self.now.x) if landed else None
        reason = None if landed else self.end
        return OracleDrop(slot, self.now.t, self.now.x, self.events, reason, _pieces=self.pieces)

    def _record(self, kind: int, index: int, approach: Real = 0) -> None:
        p = self.now
        self.events.append(Event(p.t, p.x, p.y, p.vx, p.vy, p.omega, kind, index, approach))

    def _fly_or_hit(self) -> None:
        """Bounce off a body that is touched and approached, or fly to the next impact."""
        touching = self.scene.touching(self.now.x, self.now.y)
        for body in touching:
            if self._speed_off(body) < -self.scene.tiny:
                self._hit(body)
                return
        for body in touching:
            if abs(self._speed_off(body)) < self.scene.tiny and self._stays(body):
                self._ride(body)
                return
        flight = Flight(self.scene, self.now)
        hit = first_hit(flight, touching, self.done_with, self.scene.ctx.mpf(MAX_SECONDS))
        self.done_with = []
        self.pieces.append(flight)
        self._check_outside(flight, hit.tau)
        self.now = flight.at(hit.tau)
        if hit.body is None:
            self._land()
        else:
            self._hit(hit.body)

    def _check_outside(self, flight: Flight, tau: Real) -> None:
        """Raise OracleError if a flight passed through a body."""
        for quarter in (1, 2, 3, 4):
            m = flight.moment(tau * quarter / 4)
            if self.scene.depth(m.x, m.y) > DEEPEST:
                raise OracleError(f"a flight through a body at ({float(m.x)}, {float(m.y)})")

    def _speed_off(self, body: Body) -> Real:
        nx, ny = body.normal(self.now.x, self.now.y)
        return self.now.vx * nx + self.now.vy * ny

    def _stays(self, body: Body) -> bool:
        """Whether the surface pushes the ball; never for a face that the ball left over its end."""
        if body in self.done_with:
            return False
        return pressing(self.scene, body, settle(self.scene, body, self.now))

    def _hit(self, body: Body) -> None:
        p = self.now
        nx, ny = body.normal(p.x, p.y)
        approach = -self._speed_off(body)
        vx, vy, omega = impact(p.vx, p.vy, p.omega, nx, ny, self.scene.radius, body.material)
        self.now = Point(p.t, p.x, p.y, p.theta, vx, vy, omega)
        self._shake()
        self.done_with = []
        self._record(body.kind, body.index, approach)
        touching = self.scene.touching(p.x, p.y)
        if math.hypot(vx, vy) < self.cut:
            if self._is_held(touching):
                self.end = "pinned between two bodies"
                return
            notch = self._notch(touching)
            if notch is not None:
                self.rest_in(*notch)
                return
        approached = any(self._speed_off(b) < -self.scene.tiny for b in touching)
        if self._speed_off(body) < self.cut and self._stays(body) and not approached:
            self._ride(body)

    def _is_held(self, touching: list[Body]) -> bool:
        """Whether two of the bodies carry the ball: a n1 + b n2 points straight up, a, b > 0."""
        normals = [body.normal(self.now.x, self.now.y) for body in touching]
        for (ax, ay), (bx, by) in combinations(normals, 2):
            turn = ax * by - ay * bx
            if abs(turn) > self.scene.tiny and bx / turn > 0 > ax / turn:
                return True
        return False

    def _notch(self, touching: list[Body]) -> tuple[Body, Body] | None:
        """The two bodies in whose notch a slow ball stops, or None if it touches no two.

        Bodies of the same normal are one surface.
        """
        distinct: list[Body] = []
        for body in touching:
            nx, ny = body.normal(self.now.x, self.now.y)
            others = [other.normal(self.now.x, self.now.y) for other in distinct]
            if all(abs(nx * oy - ny * ox) > NOTCH for ox, oy in others):
                distinct.append(body)
        if len(distinct) > 2:
            raise OracleError("a ball that stops at three surfaces")
        return (distinct[0], distinct[1]) if len(distinct) == 2 else None

    def rest_in(self, a: Body, b: Body) -> None:
        """A ball that has stopped in a notch spins down, then goes on along one side, or falls."""
        zero = self.scene.ctx.zero
        self.now = self.now._replace(vx=zero, vy=zero)
        if all(body.normal(self.now.x, self.now.y)[1] >= 0 for body in (a, b)):
            return  # both overhang: it falls
        brake = self._brake(a, b)
        if brake is not None:
            start, size = self.now, self.scene.radius
            span = abs(start.omega) * size / (SPIN_TERM * brake)
            self.pieces.append(Spinning(start, span))
            self.now = start._replace(
                t=start.t + span, theta=start.theta + start.omega * span / 2, omega=zero
            )
        for spin in (self.now.omega, zero):
            self.now = self.now._replace(omega=spin)
            for stays, other in ((a, b), (b, a)):
                if self._opens(stays, other):
                    self._ride(stays)
                    return
        self.end = "pinned between two bodies"

    def _brake(self, a: Body, b: Body) -> Real | None:
        """Friction's force per mass on a spinning ball that both bodies hold; None if one opens.

        With q = n + s mu t for each, s the sign of the spin: g + N_a q_a + N_b q_b = 0.
        """
        spin = self.now.omega
        if abs(spin) < self.scene.tiny:
            return None
        pulls = []
        for body in (a, b):
            nx, ny = body.normal(self.now.x, self.now.y)
            rub = body.material.friction * (1 if spin > 0 else -1)
            pulls.append((nx - rub * ny, ny + rub * nx))
        (ax, ay), (bx, by) = pulls
        turn = ax * by - ay * bx
        if abs(turn) < self.scene.tiny:
            return None
        push_a, push_b = self.scene.g * bx / turn, -self.scene.g * ax / turn
        if push_a <= 0 or push_b <= 0:
            return None
        return a.material.friction * push_a + b.material.friction * push_b or None

    def _opens(self, stays: Body, other: Body) -> bool:
        """Whether the force of `stays` alone moves a resting ball off `other`."""
        nx, ny = stays.normal(self.now.x, self.now.y)
        ox, oy = other.normal(self.now.x, self.now.y)
        push = -self.scene.g * ny
        if push <= self.scene.tiny:
            return False
        along = self.scene.g * nx
        if abs(self.now.omega) >= self.scene.tiny:
            along += stays.material.friction * push * (1 if self.now.omega > 0 else -1)
        return bool(along * (nx * oy - ny * ox) >= 0)

    def _ride(self, surface: Body) -> None:
        """A contact phase: from the end of the bounces until the ball leaves the surface."""
        state = settle(self.scene, surface, self.now)
        self._become(state)
        self._record(KIND_CONTACT_BEGIN, _contact_index(surface))
        while True:
            outcome = ride(self.scene, surface, state)
            state = outcome.state
            if outcome.stretch is not None:
                self.pieces.append(outcome.stretch)
            self._become(state)
            if outcome.end is End.RESTS or state.t > MAX_SECONDS:
                self.end = "at rest"
                return
            if outcome.end is End.LANDS:
                self._land()
                return
            if outcome.end is End.MEETS:  # the impact that follows is recorded instead
                return
            if outcome.end is End.LEAVES:
                self._shake(1)  # a slower ball would not leave yet
                self._record(KIND_CONTACT_END, _contact_index(surface))
                return
            if outcome.end is End.CHANGES:
                self._record(KIND_CONTACT_CHANGE, _contact_index(surface))
            if outcome.end is End.PASSES:
                touching = self.scene.touching(state.x, state.y)
                surface = following(self.scene, touching, state)
                state = with_slip(self.scene, surface, state)
                self._record(KIND_CONTACT_CHANGE, _contact_index(surface))
                if not pressing(self.scene, surface, state):
                    self._shake()
                    self._record(KIND_CONTACT_END, _contact_index(surface))
                    self.done_with = [f for f in touching if isinstance(f, Face)]
                    return
            if len(self.events) >= self.max_events:
                return

    def _shake(self, sign: int = 0) -> None:
        """Change speed and spin by the same tiny factor, so that a rolling ball goes on rolling."""
        if self.shake:
            p, part = self.now, 1 + self.shake * (sign or self.signs.choice((-1, 1)))
            self.now = p._replace(vx=p.vx * part, vy=p.vy * part, omega=p.omega * part)

    def _become(self, s: Riding) -> None:
        self.now = Point(s.t, s.x, s.y, s.theta, -s.u * s.ny, s.u * s.nx, s.omega)

    def _land(self) -> None:
        slot = self.scene.bin_of(self.now.x)
        self._record(KIND_LANDING, -1 if slot is None else slot)
        self.end = "landed"


def _contact_index(surface: Body) -> int:
    """The number of a surface in contact events: a peg's index, -1 - w for wall w."""
    return surface.index if surface.kind == KIND_PEG else -1 - surface.index


def _same_turns(a: Event, b: Event) -> bool:
    return a.kind == b.kind and (a.index == b.index or a.kind == KIND_LANDING)


def _spread(a: OracleDrop, b: OracleDrop) -> list[float]:
    """Distance of two runs at each event, per metre between their starts."""
    spread: list[float] = []
    for left, right in zip(a.events, b.events, strict=False):
        if not _same_turns(left, right):
            break
        distance = ((left.x - right.x) ** 2 + (left.y - right.y) ** 2) ** 0.5
        spread.append(float(distance / NUDGE))
    return spread + [math.inf] * (len(a.events) - len(spread))


def oracle_drop(
    board: Board, x_start: float, dps: int = 50, max_events: int = 4000, cut: float = CUT
) -> OracleDrop:
    """The drop of one ball on `board` from rest at (x_start, board.drop.y), to `dps` digits.

    `x_start` (m) and all floats of the board are used with their exact binary values. `cut` in
    m/s, see CUT. Raises OracleError if a decision cannot be made safely.
    """
    scene = Scene(board, dps)
    real = scene.ctx.mpf
    if cut <= 0 or real(cut) < scene.tiny:
        raise OracleError(f"cut {cut} is not above the rounding of {dps} digits")

    def again(shake: Real, pattern: int) -> OracleDrop:
        beside = real(x_start) + real(NUDGE)
        return Run(scene, beside, max_events, real(cut), real(shake), pattern).run()

    drop = Run(scene, real(x_start), max_events, real(cut)).run()
    drop._again = again
    return drop


__all__ = ["CUT", "Circle", "Event", "OracleDrop", "oracle_drop"]
