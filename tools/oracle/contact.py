"""Rolling and sliding over a peg, a wall or a wall's end, by high-order Taylor series in time.

The unknowns are the arc length s, the angle of the contact (as cosine and sine), the speed u along
the surface, and the spin. Every possible event is a series too: the ball leaves, starts or stops
slipping, meets another body, reaches the wall's end or the bins' line. The first downward zero of
such a series is found with proof.
"""

from dataclasses import dataclass
from enum import Enum

from plinko.engine.constants import KIND_PEG
from tools.oracle.flight import Point
from tools.oracle.laws import SPIN_TERM, normal_force, rolling_force
from tools.oracle.roots import OracleError, deflated, first_fall, horner
from tools.oracle.scene import Body, Circle, Face, Real, Scene

_LONGEST_STEP = 0.25  # seconds
_TRUST = 0.9  # share of the step at which the last terms of the series reach rounding


class End(Enum):
    """The reason why a stretch of contact ends."""

    STEP = "the series ends, the contact does not"
    LEAVES = "the normal force reaches zero"
    CHANGES = "rolling becomes sliding, or sliding rolling"
    MEETS = "another body is hit"
    PASSES = "the wall's face ends, or its end becomes a face"
    LANDS = "the bins' line is crossed"
    RESTS = "nothing moves and nothing will"


@dataclass(frozen=True)
class Riding:
    """A ball on a surface: contact normal, speed along (-ny, nx); slip: 0 rolls, +-1 slides."""

    t: Real
    x: Real
    y: Real
    theta: Real
    nx: Real
    ny: Real
    u: Real
    omega: Real
    slip: int


@dataclass(frozen=True)
class Outcome:
    """How and where a stretch of contact ended, and its series, which give states in between."""

    end: End
    state: Riding
    stretch: "Stretch | None"
    body: Body | None = None


def curvature(surface: Body) -> Real:
    """Curvature of the centre's path over the surface, 1/m."""
    return 1 / surface.reach if isinstance(surface, Circle) else surface.reach * 0


def settle(scene: Scene, surface: Body, p: Point) -> Riding:
    """The ball at `p` in contact with `surface`: without normal speed, rolling or sliding."""
    nx, ny = surface.normal(p.x, p.y)
    u = p.vy * nx - p.vx * ny
    x, y = p.x, p.y
    return with_slip(scene, surface, Riding(p.t, x, y, p.theta, nx, ny, u, p.omega, 0))


def with_slip(scene: Scene, surface: Body, s: Riding) -> Riding:
    """The same state with its slip set by the velocity, or by Coulomb's law if that is zero."""
    friction = surface.material.friction
    slip = s.u - s.omega * scene.radius
    if friction == 0:
        sign = 0
    elif abs(slip) >= scene.tiny:
        sign = 1 if slip > 0 else -1
    else:
        hold = rolling_force(scene.g, scene.k, s.nx, s.u)
        push = normal_force(scene.g, s.ny, s.u, curvature(surface))
        sign = 0 if abs(hold) <= friction * push else (1 if hold < 0 else -1)
        s = Riding(s.t, s.x, s.y, s.theta, s.nx, s.ny, s.u, s.u / scene.radius, 0)
    return Riding(s.t, s.x, s.y, s.theta, s.nx, s.ny, s.u, s.omega, sign)


def pressing(scene: Scene, surface: Body, s: Riding) -> bool:
    """Whether the surface pushes the ball: N > 0."""
    return bool(normal_force(scene.g, s.ny, s.u, curvature(surface)) > scene.tiny)


def following(scene: Scene, touching: list[Body], s: Riding) -> Body:
    """The body over which the ball at `s` goes on, where the piece of surface below it ends.

    All grown bodies of the same tangent there touch each other. The outermost ahead is the least
    curved: a face that goes on straight, then a peg, then the end of a wall. Neither an end that
    lies inside another wall nor the second of two equal walls is ever chosen before it.
    """
    sign = 1 if s.u > 0 else -1
    tx, ty = -sign * s.ny, sign * s.nx
    ahead = [b for b in touching if _same_normal(scene, b, s) and _goes_on(scene, b, s, tx, ty)]
    if not ahead:
        raise OracleError("a surface that ends")
    return min(ahead, key=curvature)


def _same_normal(scene: Scene, body: Body, s: Riding) -> bool:
    nx, ny = body.normal(s.x, s.y)
    return bool(abs(nx * s.ny - ny * s.nx) < scene.tiny and nx * s.nx + ny * s.ny > 0)


def _goes_on(scene: Scene, body: Body, s: Riding, tx: Real, ty: Real) -> bool:
    """Whether the surface of `body` extends from `s` in the direction (tx, ty)."""
    if isinstance(body, Face):
        along = body.along(s.x, s.y)
        left = body.length - along if body.dx * tx + body.dy * ty > 0 else along
        return bool(left > scene.tiny)
    if body.out is None:
        return True
    ox, oy = body.out
    return bool(s.nx * ox + s.ny * oy > scene.tiny or tx * ox + ty * oy > 0)


def _at_rest(scene: Scene, s: Riding) -> bool:
    tiny = scene.tiny
    still = abs(s.u) < tiny and abs(scene.g * s.nx) < tiny
    return bool(still and abs(s.u - s.omega * scene.radius) < tiny)


class Stretch:
    """One Taylor expansion of a contact, accurate for `span` seconds from its start."""

    def __init__(self, scene: Scene, surface: Body, start: Riding) -> None:
        self.scene, self.surface, self.start = scene, surface, start
        self.slides = surface.material.friction > 0 and start.slip != 0
        self.free = surface.material.friction == 0
        self._expand(scene.ctx.dps + 5)
        self.span = self._choose_span()
        scale = [scene.ctx.one]
        for _ in range(len(self.s)):
            scale.append(scale[-1] * self.span)
        for name in ("s", "u", "omega", "theta", "c", "d", "push", "hold"):
            series = getattr(self, name)
            setattr(self, name, [a * b for a, b in zip(series, scale, strict=False)])
        self.x, self.y = self._path()

    def _expand(self, order: int) -> None:
        """Series of s, u, omega, theta, normal (c, d), N and the force that would hold the slip.

        With kappa = 1/D: c' = -kappa u d, d' = kappa u c, N = -g d - kappa u^2,
        u' = g c - k u + F, omega' = -2 F / R; F = -(g c - k u)/3 rolling, -+ mu N sliding.
        """
        scene, start = self.scene, self.start
        dot = scene.ctx.fdot
        g, k, size = scene.g, scene.k, scene.radius
        kappa = curvature(self.surface)
        u, c, d = [start.u], [start.nx], [start.ny]
        omega, theta, s = [start.omega], [start.theta], [scene.ctx.zero]
        push: list[Real] = []
        hold: list[Real] = []
        rub = start.slip * self.surface.material.friction
        for j in range(order):
            square = dot(u, u[::-1]) if kappa else 0
            push.append(-g * d[j] - kappa * square)
            drive = g * c[j] - k * u[j]
            hold.append(-drive / (1 + SPIN_TERM))
            force = 0 if self.free else -rub * push[j] if self.slides else hold[j]
            s.append(u[j] / (j + 1))
            theta.append(omega[j] / (j + 1))
            if kappa:
                turn_c, turn_d = -kappa * dot(u, d[::-1]), kappa * dot(u, c[::-1])
            else:
                turn_c = turn_d = scene.ctx.zero
            u.append((drive + force) / (j + 1))
            omega.append(-SPIN_TERM * force / size / (j + 1))
            c.append(turn_c / (j + 1))
            d.append(turn_d / (j + 1))
        self.s, self.u, self.omega, self.theta = s, u, omega, theta
        self.c, self.d, self.push, self.hold = c, d, push, hold

    def _choose_span(self) -> Real:
        """Seconds for which the last two terms of each series stay below rounding."""
        ctx = self.scene.ctx
        span = ctx.mpf(_LONGEST_STEP)
        for series in (self.u, self.c, self.d, self.omega):
            for j in (len(series) - 1, len(series) - 2):
                if series[j] != 0:
                    span = min(span, _TRUST * ctx.nthroot(ctx.eps / abs(series[j]), j))
        return span

    def _path(self) -> tuple[list[Real], list[Real]]:
        """Series of the centre: middle + D n on a circle, start + s t on a face."""
        body, start = self.surface, self.start
        if isinstance(body, Circle):
            x, y = [body.reach * a for a in self.c], [body.reach * a for a in self.d]
            x[0], y[0] = x[0] + body.x, y[0] + body.y
        else:
            x, y = [-a * start.ny for a in self.s], [a * start.nx for a in self.s]
            x[0], y[0] = x[0] + start.x, y[0] + start.y
        return x, y

    def at(self, share: Real) -> Riding:
        """The state at `share` (0 to 1) of the span."""
        now = [horner(series, share)[0] for series in self._state()]
        x, y, theta, c, d, u, omega = now
        size = (
            c * c + d * d
        ) ** 0.5  # is 1 up to rounding; divided out, so that errors do not grow
        t = self.start.t + share * self.span
        return Riding(t, x, y, theta, c / size, d / size, u, omega, self.start.slip)

    def _state(self) -> tuple[list[Real], ...]:
        return self.x, self.y, self.theta, self.c, self.d, self.u, self.omega

    def point(self, share: Real) -> Point:
        """The state at `share` of the span as a Point."""
        s = self.at(share)
        return Point(s.t, s.x, s.y, s.theta, -s.u * s.ny, s.u * s.nx, s.omega)

    def first_event(self) -> tuple[Real, End, Body | None]:
        """The first event within the span as (share, what, body); (1, STEP, None) without one."""
        found: list[tuple[Real, End, Body | None]] = []
        for end, body, series in self._events():
            share = self._first(series)
            if share is not None:
                found.append((share, end, body))
        found.extend((share, End.MEETS, other) for other, share in self._others())
        if not found:
            return self.scene.ctx.one, End.STEP, None
        return min(found, key=lambda event: event[0])

    def _first(self, series: list[Real]) -> Real | None:
        """First downward zero of a series that starts at or above zero; 0 if it falls at once."""
        cleared = deflated(series, self.scene.tiny)
        if not cleared:
            return None
        if cleared[0] < 0:
            return self.scene.ctx.zero if len(cleared) < len(series) else None
        return first_fall(cleared, self.scene.ctx.eps)

    def _first_into(self, series: list[Real]) -> Real | None:
        """First fall through a face's line, even if the ball is behind that line at the start."""
        if series[0] < -self.scene.tiny:
            return first_fall(series, self.scene.ctx.eps)
        return self._first(series)

    def _events(self) -> list[tuple[End, Body | None, list[Real]]]:
        """Each possible event of this stretch, as a series that is positive until it happens."""
        scene, body = self.scene, self.surface
        size = len(self.push)
        fall = [-a for a in self.y]
        fall[0] += scene.bins_y
        events: list[tuple[End, Body | None, list[Real]]] = [
            (End.LEAVES, None, self.push),
            (End.LANDS, None, fall),
        ]
        mu = body.material.friction
        if self.slides:
            sign = self.start.slip
            slip = [sign * (a - b * scene.radius) for a, b in zip(self.u, self.omega, strict=True)]
            events.append((End.CHANGES, None, slip))
        elif not self.free:
            for sign in (1, -1):
                spare = [mu * self.push[j] + sign * self.hold[j] for j in range(size)]
                events.append((End.CHANGES, None, spare))
        events.extend((End.PASSES, None, series) for series in self._limits())
        return events

    def _limits(self) -> list[list[Real]]:
        """Distances to a face's ends, or on a wall's end to the faces of all walls there."""
        body = self.surface
        if isinstance(body, Face):
            turn = self.start.nx * body.dy - self.start.ny * body.dx  # t.d: +1 or -1
            begun = body.along(self.start.x, self.start.y)
            along = [turn * a for a in self.s]
            along[0] += begun
            rest = [-a for a in along]
            rest[0] += body.length
            return [along, rest]
        limits: list[list[Real]] = []
        for end in self.scene.circles:
            if end.out is not None and body.out is not None and self._same_place(end, body):
                ox, oy = end.out
                limits.append([a * ox + b * oy for a, b in zip(self.c, self.d, strict=True)])
        return limits

    def _same_place(self, a: Circle, b: Circle) -> bool:
        tiny = self.scene.tiny
        return bool(abs(a.x - b.x) < tiny and abs(a.y - b.y) < tiny)

    def _part_of_surface(self, other: Body) -> bool:
        """Whether `other` continues the surface: the same wall, or one that shares its end."""
        body = self.surface
        if other.kind == body.kind and other.index == body.index:
            return True
        if KIND_PEG in (body.kind, other.kind):
            return False
        if isinstance(body, Face):
            if isinstance(other, Face):
                return False
            off_line = body.gap(other.x, other.y) + body.reach
            return bool(abs(off_line) < self.scene.tiny)
        ends = [c for c in self.scene.circles if c.out is not None and c.index == other.index]
        shares = any(self._same_place(end, body) for end in ends)
        return shares and (isinstance(other, Face) or self._same_place(other, body))

    def _others(self) -> list[tuple[Body, Real]]:
        """The other bodies that this stretch reaches, and the shares at which it first does."""
        scene = self.scene
        roam = float(sum(abs(a) for a in self.s)) + 1e-9
        x, y = self.start.x, self.start.y
        found: list[tuple[Body, Real]] = []
        circles, faces = scene.near(x, y, roam)
        for circle in circles:
            if self._part_of_surface(circle):
                continue
            dx, dy = list(self.x), list(self.y)
            dx[0], dy[0] = dx[0] - circle.x, dy[0] - circle.y
            series = [a + b for a, b in zip(self._square(dx), self._square(dy), strict=True)]
            series[0] -= circle.reach * circle.reach
            share = self._first(series)
            if share is not None:
                found.append((circle, share))
        for face in faces:
            if self._part_of_surface(face):
                continue
            series = [a * face.nx + b * face.ny for a, b in zip(self.x, self.y, strict=True)]
            series[0] = face.gap(x, y)
            share = self._first_into(series)
            if share is not None and self._on(face, share):
                found.append((face, share))
        return found

    def _on(self, face: Face, share: Real) -> bool:
        along = face.along(horner(self.x, share)[0], horner(self.y, share)[0])
        return bool(0 <= along <= face.length)

    def _square(self, series: list[Real]) -> list[Real]:
        """The series squared, to the same order."""
        dot = self.scene.ctx.fdot
        return [dot(series[: j + 1], series[j::-1]) for j in range(len(series))]


def ride(scene: Scene, surface: Body, start: Riding) -> Outcome:
    """One stretch of contact from `start` to its first event, or to the end of the series' step."""
    if _at_rest(scene, start):
        return Outcome(End.RESTS, start, None)
    if not pressing(scene, surface, start):
        raise OracleError("a contact without a normal force")
    stretch = Stretch(scene, surface, start)
    share, end, body = stretch.first_event()
    state = stretch.at(share)
    if end is End.CHANGES:
        rolled = start.slip != 0
        omega = state.u / scene.radius
        state = Riding(
            state.t, state.x, state.y, state.theta, state.nx, state.ny, state.u, omega, 0
        )
        state = with_slip(scene, surface, state) if rolled else _lets_go(scene, state)
    return Outcome(end, state, stretch, body)


def _lets_go(scene: Scene, s: Riding) -> Riding:
    """Rolling becomes sliding, because friction is too weak: it slides against the force needed."""
    hold = rolling_force(scene.g, scene.k, s.nx, s.u)
    sign = 1 if hold < 0 else -1
    return Riding(s.t, s.x, s.y, s.theta, s.nx, s.ny, s.u, s.omega, sign)
