"""Free flight in closed form and its first hit, found by bisection with derivative bounds.

This code is independent of the engine's kernels. Let f(t) = |p - c|^2 - D^2. Bounds on the first
four derivatives of f around the middle of an interval show that f has no zero there, or that it is
monotone, convex or concave; otherwise the interval is halved. Extrema and roots are then bracketed
and refined to all digits. A graze is an impact exactly if the minimum of f is negative.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tools.oracle.roots import OracleError, bracketed
from tools.oracle.scene import Body, Circle, Face, Real, Scene

_MAX_DEPTH = 400
_SCREEN_MARGIN = 1e-9  # metres; float64 rounding of the screen is a millionth of this


class Point(NamedTuple):
    """The full state of the ball: seconds, metres, radians, m/s, rad/s."""

    t: Real
    x: Real
    y: Real
    theta: Real
    vx: Real
    vy: Real
    omega: Real


class Hit(NamedTuple):
    """The end of a flight: seconds after its start, and the body hit (None: the bins' line)."""

    tau: Real
    body: Body | None


class _Moment(NamedTuple):
    x: Real
    y: Real
    vx: Real
    vy: Real
    ax: Real
    ay: Real


class Flight:
    """dv/dt = g - k v: v = v_T + (v_0 - v_T) e^(-k t) with v_T = g / k; a parabola for k = 0."""

    def __init__(self, scene: Scene, start: Point) -> None:
        self.scene, self.start = scene, start

    def moment(self, tau: Real) -> _Moment:
        """Position, velocity and acceleration `tau` seconds after the start."""
        s, g, k = self.start, self.scene.g, self.scene.k
        if k == 0:
            zero = tau * 0
            y = s.y + tau * (s.vy + g * tau / 2)
            return _Moment(s.x + s.vx * tau, y, s.vx, s.vy + g * tau, zero, g + zero)
        lost = -self.scene.ctx.expm1(-k * tau)  # 1 - e^(-k tau)
        fall = g / k
        left = 1 - lost
        vx, vy = s.vx * left, fall + (s.vy - fall) * left
        x = s.x + s.vx * lost / k
        y = s.y + fall * tau + (s.vy - fall) * lost / k
        return _Moment(x, y, vx, vy, -k * vx, g - k * vy)

    def at(self, tau: Real) -> Point:
        """The whole state `tau` seconds after the start."""
        m, s = self.moment(tau), self.start
        return Point(s.t + tau, m.x, m.y, s.theta + s.omega * tau, m.vx, m.vy, s.omega)


@dataclass
class _Chase:
    """The search for the first entry into one circle on one stretch of a flight."""

    flight: Flight
    circle: Circle
    eps: Real

    def terms(self, tau: Real) -> tuple[Real, Real, Real]:
        """f, f' and f'' at tau."""
        m = self.flight.moment(tau)
        qx, qy = m.x - self.circle.x, m.y - self.circle.y
        f = qx * qx + qy * qy - self.circle.reach * self.circle.reach
        first = 2 * (qx * m.vx + qy * m.vy)
        second = 2 * (m.vx * m.vx + m.vy * m.vy + qx * m.ax + qy * m.ay)
        return f, first, second

    def f(self, tau: Real) -> tuple[Real, Real]:
        return self.terms(tau)[:2]

    def slope(self, tau: Real) -> tuple[Real, Real]:
        return self.terms(tau)[1:]

    def entry(self, low: Real, high: Real, own: bool, depth: int = 0) -> Real | None:
        """First entry in (low, high]; `own`: the ball is on this circle at `low` and leaves it."""
        verdict = self._judge(low, high, own)
        if verdict is not None:
            return self._settle(verdict, low, high, own)
        if depth > _MAX_DEPTH:
            raise OracleError("a graze: bisection cannot decide whether it is a hit")
        middle = (low + high) / 2
        found = self.entry(low, middle, own, depth + 1)
        if found is not None:
            return found
        if self.f(middle)[0] <= 0:
            raise OracleError("inside a body without having entered it")
        return self.entry(middle, high, False, depth + 1)

    def _judge(self, low: Real, high: Real, own: bool) -> str | None:
        """How f behaves on the interval: far, rising, falling, convex or concave; None: unknown."""
        k = self.flight.scene.k
        middle, half = (low + high) / 2, (high - low) / 2
        m, start = self.flight.moment(middle), self.flight.moment(low)
        qx, qy = m.x - self.circle.x, m.y - self.circle.y
        pull = (start.ax**2 + start.ay**2) ** 0.5  # |a| only decays
        speed = (m.vx**2 + m.vy**2) ** 0.5
        fast = speed + pull * half
        distance = (qx * qx + qy * qy) ** 0.5
        roam = speed * half + pull * half * half / 2
        if distance - roam > self.circle.reach and not own:
            return "far"
        far = distance + roam
        second_bound = 2 * (fast * fast + far * pull)
        third_bound = 2 * pull * (3 * fast + far * k)
        first = 2 * (qx * m.vx + qy * m.vy)
        second = 2 * (m.vx**2 + m.vy**2 + qx * m.ax + qy * m.ay)
        if abs(first) > half * second_bound:
            return "rising" if first > 0 else "falling"
        if abs(second) > half * third_bound:
            return "convex" if second > 0 else "concave"
        if own:
            third = 2 * (3 * (m.vx * m.ax + m.vy * m.ay) - k * (qx * m.ax + qy * m.ay))
            fourth_bound = 2 * pull * (3 * pull + 4 * k * fast + k * k * far)
            if third > half * fourth_bound and self._starts_flat(low):
                return "rising"
        return None

    def _starts_flat(self, low: Real) -> bool:
        """Whether the ball has just left at zero normal force: f = f' = 0 <= f''."""
        _, first, second = self.terms(low)
        tiny = self.flight.scene.tiny
        return bool(first > -tiny and second > -tiny)

    def _settle(self, verdict: str, low: Real, high: Real, own: bool) -> Real | None:
        """The first entry on an interval on which f behaves as `verdict` says."""
        if verdict in ("far", "rising"):
            return None
        if own and verdict in ("falling", "convex"):
            if verdict == "convex" and self.slope(low)[0] > -self.flight.scene.tiny:
                return None
            raise OracleError("a ball that leaves a body into it")
        if verdict == "convex":
            if self.slope(low)[0] >= 0:
                return None
            if self.slope(high)[0] > 0:
                high = self._extremum(low, high)
        elif verdict == "concave" and self.slope(low)[0] > 0 >= self.slope(high)[0]:
            low = self._extremum(low, high)
        value, slope = self.f(high)
        inside = value < 0 or (value == 0 and slope < 0)  # a mere touch does not count
        return self._root(low, high) if inside else None

    def _extremum(self, low: Real, high: Real) -> Real:
        return bracketed(self.slope, low, high, self.eps)

    def _root(self, low: Real, high: Real) -> Real:
        return bracketed(self.f, low, high, self.eps)


def _line_entry(
    flight: Flight, point: tuple[Real, Real], normal: tuple[Real, Real], low: Real, high: Real
) -> Real | None:
    """The time in (low, high] at which the signed distance (p - point).n falls below zero, or None.

    Its second derivative is n.a, and the acceleration a never changes its direction. The distance
    is therefore convex or concave throughout, with at most one root on each side of its extremum.
    """
    eps = flight.scene.ctx.eps
    nx, ny = normal

    def terms(tau: Real) -> tuple[Real, Real, Real]:
        m = flight.moment(tau)
        value = (m.x - point[0]) * nx + (m.y - point[1]) * ny
        return value, m.vx * nx + m.vy * ny, m.ax * nx + m.ay * ny

    value_low, slope_low, bend = terms(low)
    value_high, slope_high, _ = terms(high)
    if bend > 0:  # convex: falls first
        if value_low <= 0 or slope_low >= 0:
            return None
        if slope_high > 0:
            high = bracketed(lambda tau: terms(tau)[1:], low, high, eps)
            value_high = terms(high)[0]
    else:  # concave: falls last
        if value_high > 0 or slope_high >= 0:
            return None
        if slope_low > 0:
            low = bracketed(lambda tau: terms(tau)[1:], low, high, eps)
            value_low = terms(low)[0]
    if value_low <= 0 or value_high > 0:
        return None
    return bracketed(lambda tau: terms(tau)[:2], low, high, eps)


def first_hit(flight: Flight, touching: list[Body], done_with: list[Face], limit: Real) -> Hit:
    """The first hit after the start, or the fall through the bins' line, whichever comes first.

    `touching`: bodies that the ball touches at the start without approaching them. `done_with`:
    faces that the ball left over their ends, whose lines it cannot fall through again. `limit`:
    seconds after which the search gives up with an OracleError.
    """
    scene = flight.scene
    longest = (scene.smallest / scene.g) ** 0.5 * 3 / 10
    low, step = scene.ctx.zero, min(longest, _hop(flight, touching))
    while low < limit:
        high = low + step
        hits = _hits(flight, low, high, touching if low == 0 else [], done_with)
        if hits:
            order = [
                (h.tau, h.body.kind if h.body else 9, h.body.index if h.body else 0) for h in hits
            ]
            return hits[order.index(min(order))]
        low, step = high, min(longest, 2 * step)
    raise OracleError("a flight that hits nothing and never lands")


def _hop(flight: Flight, touching: list[Body]) -> Real:
    """A first step for the search: twice the shortest bounce back onto a touched body."""
    m = flight.moment(flight.scene.ctx.zero)
    hop = flight.scene.ctx.inf
    for body in touching:
        nx, ny = body.normal(m.x, m.y)
        leave = m.vx * nx + m.vy * ny
        pull = m.ax * nx + m.ay * ny
        if isinstance(body, Circle):
            pull += (m.vx**2 + m.vy**2 - leave**2) / body.reach
        if leave > flight.scene.tiny and pull < 0:
            hop = min(hop, -4 * leave / pull)
    return hop


def _hits(
    flight: Flight, low: Real, high: Real, touching: list[Body], done_with: list[Face]
) -> list[Hit]:
    """The first entry into each body, and through the bins' line, on one stretch of the flight."""
    scene = flight.scene
    start, end = flight.moment(low), flight.moment(high)
    pull = float((start.ax**2 + start.ay**2) ** 0.5)
    bulge = pull * float(high - low) ** 2 / 8 + _SCREEN_MARGIN
    hits: list[Hit] = []
    for circle in _near(scene, start, end, bulge):
        chase = _Chase(flight, circle, scene.ctx.eps)
        tau = chase.entry(low, high, circle in touching)
        if tau is not None:
            hits.append(Hit(tau, circle))
    for face in scene.faces:
        gaps = float(face.gap(start.x, start.y)), float(face.gap(end.x, end.y))
        if face in done_with or min(gaps) > bulge or max(gaps) < -bulge:
            continue
        point = face.x + face.nx * face.reach, face.y + face.ny * face.reach
        tau = _line_entry(flight, point, (face.nx, face.ny), low, high)
        if tau is not None:
            m = flight.moment(tau)
            if 0 <= face.along(m.x, m.y) <= face.length:
                hits.append(Hit(tau, face))
    if float(end.y) > float(scene.bins_y) - bulge:
        tau = _line_entry(flight, (scene.ctx.zero, scene.bins_y), (0, -1), low, high)
        if tau is not None:
            hits.append(Hit(tau, None))
    return hits


def _near(scene: Scene, start: _Moment, end: _Moment, bulge: float) -> list[Circle]:
    """Circles within `bulge` of the chord from start to end: a safe screen in float64."""
    if not scene.circles:
        return []
    ax, ay = float(start.x), float(start.y)
    ex, ey = float(end.x) - ax, float(end.y) - ay
    qx, qy = scene.middles[:, 0] - ax, scene.middles[:, 1] - ay
    share = np.clip((qx * ex + qy * ey) / max(ex * ex + ey * ey, 1e-300), 0.0, 1.0)
    distance = np.hypot(qx - share * ex, qy - share * ey)
    return [scene.circles[i] for i in np.flatnonzero(distance < scene.middles[:, 2] + bulge)]
