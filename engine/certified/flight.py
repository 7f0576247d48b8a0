"""Free flight in ball arithmetic, and the distance from the ball to a circle or a line.

dv/dt = g - k v, so with a = g - k v at the start and phi, psi as in `engine/physics/flight.py`

    v(s) = v + a phi(s)        r(s) = r + v s + a psi(s)

A time s may be a ball with a width. The state is then expanded about its middle m, by the
identities phi(m + d) = phi(m) + e^(-km) phi(d) and psi(m + d) = psi(m) + phi(m) d + e^(-km) psi(d).
So the width of s enters only once, times the velocity; in r + v s + a psi(s) it would enter twice.
"""

from dataclasses import dataclass
from math import frexp
from typing import NamedTuple

from flint import arb, ctx

from plinko.engine.certified.balls import ONE, ZERO, UndecidedError
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.screen import Course
from plinko.engine.certified.surfaces import Circle, Face


@dataclass(frozen=True, slots=True)
class State:
    """Enclosures of a ball's time, position, velocity and spin: s, m, m/s and rad/s."""

    t: arb
    x: arb
    y: arb
    vx: arb
    vy: arb
    omega: arb


class Moment(NamedTuple):
    """Position and velocity at a time of a flight, and e^(-ks), which scales the acceleration."""

    x: arb
    y: arb
    vx: arb
    vy: arb
    decay: arb


class Flight:
    """The free motion from `start` on."""

    def __init__(self, scene: Scene, start: State) -> None:
        self.start = start
        self.k = scene.drag
        self.has_drag = bool(scene.drag > 0)
        self.ax = -self.k * start.vx
        self.ay = scene.gravity - self.k * start.vy
        self.va = start.vx * self.ax + start.vy * self.ay
        self.vv = start.vx * start.vx + start.vy * start.vy
        self.aa = self.ax * self.ax + self.ay * self.ay
        parts = start.x, start.y, start.vx, start.vy, self.ax, self.ay
        self.course = Course.of(parts, self.k)

    def basis(self, s: arb) -> tuple[arb, arb, arb]:
        """e^(-ks), phi(s) and psi(s) at an exact time s."""
        if not self.has_drag:
            return ONE, s, s * s / 2
        # Both subtractions cancel for small ks, and lose 2 log2(1 / ks) bits: compute with more.
        bits = ctx.prec
        ctx.prec = bits + 8 + max(0, -2 * frexp(float(self.k * s))[1])
        lost = -((-self.k * s).expm1())
        phi = lost / self.k
        psi = (s - phi) / self.k
        ctx.prec = bits
        return 1 - lost, +phi, +psi

    def moment(self, s: arb) -> Moment:
        """Position and velocity at time s."""
        middle = s.mid()
        start = self.start
        decay, phi, psi = self.basis(middle)
        x = start.x + start.vx * middle + self.ax * psi
        y = start.y + start.vy * middle + self.ay * psi
        vx, vy = start.vx + self.ax * phi, start.vy + self.ay * phi
        if s.is_exact():
            return Moment(x, y, vx, vy, decay)
        d = s - middle
        gain, bend = self.beyond(decay, d)
        x = x + vx * d + self.ax * bend
        y = y + vy * d + self.ay * bend
        return Moment(x, y, vx + self.ax * gain, vy + self.ay * gain, decay - self.k * gain)

    def beyond(self, decay: arb, d: arb) -> tuple[arb, arb]:
        """e^(-km) phi(d) and e^(-km) psi(d), with `decay` e^(-km) at the middle m of a time.

        |psi(d)| < d^2 holds for k|d| < 1/2. A root's enclosure is far narrower; a wider time is
        undecided.
        """
        if not 2 * self.k * abs(d) < 1:
            raise UndecidedError("where the ball is at a time that is enclosed too widely")
        bend = decay * arb(0, (d * d).abs_upper())
        return decay * d - self.k * bend, bend

    def at(self, s: arb) -> State:
        """The whole state at time s."""
        m = self.moment(s)
        return State(self.start.t + s, m.x, m.y, m.vx, m.vy, self.start.omega)


class CircleDistance:
    """f(s) = |q(s)|^2 - D^2 in m^2, with q from the circle's centre, its derivatives and bounds.

    f' = 2 q.v, f'' = 2 (|v|^2 + q.a), f''' = 6 v.a - 2 k q.a. `low3` is a lower bound of f''' until
    `end`, `size3` an upper bound of |f'''|.
    """

    def __init__(self, flight: Flight, circle: Circle, end: float) -> None:
        self.flight, self.circle = flight, circle
        self.square = circle.reach * circle.reach
        start = flight.start
        self.qx, self.qy = start.x - circle.x, start.y - circle.y
        self.qa = self.qx * flight.ax + self.qy * flight.ay
        horizon = arb(end)
        low, size = 6 * _below_zero(flight.va), 6 * (abs(flight.va) + flight.aa * horizon)
        if flight.has_drag:
            rise = self.qa + flight.aa * horizon * horizon / 2 + _above_zero(flight.va) * horizon
            low = low - 2 * flight.k * _above_zero(rise)
            way = (abs(flight.va) + flight.aa * horizon / 2) * horizon
            size = size + 2 * flight.k * (abs(self.qa) + way)
        self.low3, self.size3 = low.lower(), size.upper()

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """f, f' and f'' at s."""
        m = self.flight.moment(s)
        qx, qy = m.x - self.circle.x, m.y - self.circle.y
        pull = m.decay * (qx * self.flight.ax + qy * self.flight.ay)
        return (
            qx * qx + qy * qy - self.square,
            2 * (qx * m.vx + qy * m.vy),
            2 * (m.vx * m.vx + m.vy * m.vy + pull),
        )

    def least_bend(self, bend: arb, h: arb) -> arb:
        """m such that f(s + d) >= f + f' d + m d^2 / 2 for d up to h; f'' is `bend` at s."""
        return bend + self.low3 * h / 3

    def most_bend(self, bend: arb, h: arb) -> arb:
        """An upper bound of f'' between s and s + h."""
        return bend + self.size3 * h


class ReboundDistance:
    """g(s) = f(s) / s for a ball that leaves the circle at s = 0, where f has a root.

    With w = v + a psi / s: q = q0 + s w and g = 2 q0.w + s |w|^2. g is the mean of f' over [0, s],
    so a third of the bounds of f''' are bounds of g''.
    """

    def __init__(self, flight: Flight, circle: Circle, off: arb, end: float) -> None:
        """`off` is v.n at the start, known more sharply than from v and n."""
        self.flight, self.twice = flight, 2 * circle.reach
        of_f = CircleDistance(flight, circle, end)
        self.rate, self.qa = circle.reach * off, of_f.qa
        self.low2, self.size2 = of_f.low3 / 3, of_f.size3 / 3

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """g and g' at s, and 0, as the bounds do not need g''."""
        flight = self.flight
        start = flight.start
        if s.is_zero():
            return 2 * self.rate, flight.vv + self.qa, ZERO
        c, cd = _quotient(flight, s)
        wx, wy = start.vx + flight.ax * c, start.vy + flight.ay * c
        ww = wx * wx + wy * wy
        wa = wx * flight.ax + wy * flight.ay
        g = 2 * (self.rate + self.qa * c) + s * ww
        return g, 2 * self.qa * cd + ww + 2 * s * cd * wa, ZERO

    def approach(self, s: arb) -> arb:
        """v.n at the root s of g, where f' = s g' and f' = 2 D v.n."""
        return s * self.terms(s)[1] / self.twice

    def least_bend(self, bend: arb, h: arb) -> arb:
        return self.low2

    def most_bend(self, bend: arb, h: arb) -> arb:
        return self.size2


class LineDistance:
    """The distance h(s) = h + h' s + h'' psi(s) to a line, in m; h'' keeps its sign."""

    def __init__(self, flight: Flight, gap: arb, rate: arb, pull: arb) -> None:
        self.flight, self.gap, self.rate, self.pull = flight, gap, rate, pull

    @classmethod
    def of_face(cls, flight: Flight, face: Face) -> "LineDistance":
        """The distance to the line on which the centre of a ball lies that touches the face."""
        start, nx, ny = flight.start, face.nx, face.ny
        gap = (start.x - face.x) * nx + (start.y - face.y) * ny - face.reach
        rate = start.vx * nx + start.vy * ny
        return cls(flight, gap, rate, flight.ax * nx + flight.ay * ny)

    @classmethod
    def to_bins(cls, flight: Flight, bins_y: arb) -> "LineDistance":
        """The distance to the bins' line, where drops end."""
        return cls(flight, bins_y - flight.start.y, -flight.start.vy, -flight.ay)

    def turned(self) -> "LineDistance":
        """The distance to the same line from its other side."""
        return LineDistance(self.flight, -self.gap, -self.rate, -self.pull)

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """h, h' and h'' at s."""
        decay, phi, psi = wide_basis(self.flight, s)
        value = self.gap + self.rate * s + self.pull * psi
        return value, self.rate + self.pull * phi, self.pull * decay

    def least_bend(self, bend: arb, h: arb) -> arb:
        """As of CircleDistance: |h''| only shrinks."""
        return _below_zero(bend)

    def most_bend(self, bend: arb, h: arb) -> arb:
        return _above_zero(bend)


class LineRebound:
    """h(s) / s for h(0) = 0: rate + pull psi(s) / s, whose second derivative is `pull` times a
    number between -k / 3 and 0."""

    def __init__(self, line: LineDistance) -> None:
        self.line = line
        bend = -line.pull * line.flight.k / 3
        self.low2, self.high2 = _below_zero(bend), _above_zero(bend)

    def terms(self, s: arb) -> tuple[arb, arb, arb]:
        """The quotient and its derivative at s, and 0, as the bounds do not need the second one."""
        line = self.line
        if s.is_zero():
            return line.rate, line.pull / 2, ZERO
        c, cd = _quotient(line.flight, s)
        return line.rate + line.pull * c, line.pull * cd, ZERO

    def approach(self, s: arb) -> arb:
        """v.n at the root s: there h' is s times the derivative of the quotient."""
        return s * self.terms(s)[1]

    def least_bend(self, bend: arb, h: arb) -> arb:
        return self.low2

    def most_bend(self, bend: arb, h: arb) -> arb:
        return self.high2


def wide_basis(flight: Flight, s: arb) -> tuple[arb, arb, arb]:
    """`Flight.basis` at a time that may have a width."""
    middle = s.mid()
    decay, phi, psi = flight.basis(middle)
    if s.is_exact():
        return decay, phi, psi
    d = s - middle
    gain, bend = flight.beyond(decay, d)
    return decay - flight.k * gain, phi + gain, psi + phi * d + bend


def _quotient(flight: Flight, s: arb) -> tuple[arb, arb]:
    """c = psi(s) / s and its derivative; 0 <= c' <= 1/2 and c'' >= -k / 3."""
    if not flight.has_drag:
        return s / 2, ONE / 2
    middle = s.mid()
    _, phi, psi = flight.basis(middle)
    c = psi / middle
    cd = (phi - c) / middle
    if s.is_exact():
        return c, cd
    d = s - middle
    return c + d / 2, cd + d * flight.k / 3


def _below_zero(x: arb) -> arb:
    """min(x, 0), enclosed from below."""
    return ZERO if x >= 0 else arb.min(x, ZERO).lower()


def _above_zero(x: arb) -> arb:
    """max(x, 0), enclosed from above."""
    return ZERO if x <= 0 else arb.max(x, ZERO).upper()
